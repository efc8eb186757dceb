# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``MotionPlanRequest``, ``Constraints`` and ``RobotState`` to plain values, and answers back."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, TypeVar

from geometry_msgs.msg import Pose
from moveit_msgs.msg import (
    AttachedCollisionObject,
    DisplayTrajectory,
    MoveItErrorCodes,
    RobotState,
    RobotTrajectory,
)
from moveit_msgs.msg import Constraints as ConstraintsMessage
from moveit_msgs.msg import MotionPlanRequest as MotionPlanRequestMessage
from moveit_msgs.msg import OrientationConstraint as OrientationConstraintMessage
from moveit_msgs.msg import PositionConstraint as PositionConstraintMessage
from moveit_msgs.msg import WorkspaceParameters as WorkspaceMessage
from shape_msgs.msg import Mesh

from armsim_ros.errors import PlanningError
from armsim_ros.model.geometry import Geometry
from armsim_ros.nodes.conversions.collision_object import (
    attached_in_state_from_message,
    attached_object_to_message,
)
from armsim_ros.nodes.conversions.geometry import (
    mesh_from_message,
    missing_primitive,
    pose_from_message,
    primitive_from_message,
)
from armsim_ros.nodes.conversions.trajectory import trajectory_to_message
from armsim_ros.planning.request import (
    Constraints,
    JointConstraint,
    MotionPlanRequest,
    OrientationConstraint,
    PositionConstraint,
    Region,
    VisibilityConstraint,
    WorkspaceParameters,
)
from armsim_ros.planning.scene.objects import AttachedObject
from armsim_ros.planning.scene.update import StartState
from armsim_ros.trajectory import JointTrajectory

Shape = TypeVar('Shape')


def constraints_from_message(message: ConstraintsMessage) -> Constraints:
    """
    Return the constraints of a message; shapes without dimensions or a pose are left out.

    :raises PlanningError: for a region whose dimensions or pose cannot exist.
    """
    return Constraints(
        name=message.name,
        joint_constraints=tuple(
            JointConstraint(
                joint_name=item.joint_name, position=float(item.position),
                tolerance_above=float(item.tolerance_above),
                tolerance_below=float(item.tolerance_below), weight=float(item.weight))
            for item in message.joint_constraints),
        position_constraints=tuple(_position(item) for item in message.position_constraints),
        orientation_constraints=tuple(
            _orientation(item) for item in message.orientation_constraints),
        visibility_constraints=tuple(
            VisibilityConstraint(
                target_radius=float(item.target_radius),
                target_pose=pose_from_message(item.target_pose.pose),
                target_frame_id=item.target_pose.header.frame_id,
                sensor_pose=pose_from_message(item.sensor_pose.pose),
                sensor_frame_id=item.sensor_pose.header.frame_id, cone_sides=int(item.cone_sides),
                max_view_angle=float(item.max_view_angle),
                max_range_angle=float(item.max_range_angle),
                sensor_view_direction=int(item.sensor_view_direction))
            for item in message.visibility_constraints))


def _position(message: PositionConstraintMessage) -> PositionConstraint:
    volume = message.constraint_region
    left_out: list[str] = []
    regions = [
        *_regions(volume.primitives, volume.primitive_poses, missing_primitive,
                  primitive_from_message, left_out),
        *_regions(volume.meshes, volume.mesh_poses, _missing_mesh, mesh_from_message, left_out)]
    offset = message.target_point_offset
    return PositionConstraint(
        link_name=message.link_name, regions=tuple(regions), frame_id=message.header.frame_id,
        target_point_offset=(float(offset.x), float(offset.y), float(offset.z)),
        weight=float(message.weight), left_out=tuple(left_out),
        primitive_poses=tuple(pose_from_message(pose) for pose in volume.primitive_poses))


def _regions(
    shapes: Sequence[Shape], poses: Sequence[Pose], missing: Callable[[Shape], str],
    converted: Callable[[Shape], Geometry], left_out: list[str],
) -> Iterator[Region]:
    """Yield the shapes that have a pose, and note why the others are left out."""
    for index, shape in enumerate(shapes):
        reason = missing(shape) or ('' if index < len(poses) else 'a shape has no pose')
        if reason:
            left_out.append(reason)
        else:
            yield Region(converted(shape), pose_from_message(poses[index]))


def _missing_mesh(message: Mesh) -> str:
    return '' if message.triangles else 'a mesh has no triangles'


def _orientation(message: OrientationConstraintMessage) -> OrientationConstraint:
    quaternion = message.orientation
    return OrientationConstraint(
        link_name=message.link_name,
        quat_xyzw=(
            float(quaternion.x), float(quaternion.y), float(quaternion.z), float(quaternion.w)),
        tolerances=(
            float(message.absolute_x_axis_tolerance), float(message.absolute_y_axis_tolerance),
            float(message.absolute_z_axis_tolerance)),
        frame_id=message.header.frame_id,
        parameterization=int(message.parameterization),
        weight=float(message.weight))


Value = TypeVar('Value')


def readable(
    convert: Callable[[Any], Value], messages: Iterable[Any]
) -> tuple[tuple[Value, ...], tuple[PlanningError, ...]]:
    """Return what could be converted, and why the rest could not."""
    values: list[Value] = []
    errors: list[PlanningError] = []
    for message in messages:
        try:
            values.append(convert(message))
        except PlanningError as error:
            errors.append(error)
    return tuple(values), tuple(errors)


def start_state_from_message(
    message: RobotState,
    convert: Callable[[AttachedCollisionObject], AttachedObject] = attached_in_state_from_message,
) -> StartState:
    """
    Return the state as it was given; joints are checked where it is used.

    A multi-DOF joint is left out: a fixed arm has none.

    :param convert: reads an attached object; by default as that of a request's start state.
    """
    attached, unreadable = readable(convert, message.attached_collision_objects)
    return StartState(
        joint_names=tuple(message.joint_state.name),
        positions=tuple(float(value) for value in message.joint_state.position),
        velocities=tuple(float(value) for value in message.joint_state.velocity),
        is_diff=bool(message.is_diff), attached_objects=attached, unreadable=unreadable)


def robot_state_to_message(
    positions: Mapping[str, float], frame_id: str, *, attached: Iterable[AttachedObject] = (),
    is_diff: bool = False
) -> RobotState:
    """
    Return a full robot state.

    :param positions: joint -> [rad or m].
    :param frame_id: the model frame, for the header.
    :param attached: objects that the robot carries.
    """
    message = RobotState(is_diff=is_diff)
    message.joint_state.header.frame_id = frame_id
    message.joint_state.name = list(positions)
    message.joint_state.position = [float(value) for value in positions.values()]
    message.attached_collision_objects = [attached_object_to_message(item) for item in attached]
    return message


def request_from_message(message: MotionPlanRequestMessage, seed: int = -1) -> MotionPlanRequest:
    """
    Return the request of a message as it was given.

    :param seed: of the search; negative for a different seed each time.
    :raises PlanningError: for shapes or poses that cannot exist.
    """
    return MotionPlanRequest(
        group_name=message.group_name,
        goal_constraints=tuple(
            constraints_from_message(item) for item in message.goal_constraints),
        start_state=start_state_from_message(message.start_state),
        path_constraints=constraints_from_message(message.path_constraints),
        pipeline_id=message.pipeline_id,
        planner_id=message.planner_id,
        num_planning_attempts=int(message.num_planning_attempts),
        allowed_planning_time=float(message.allowed_planning_time),
        max_velocity_scaling_factor=float(message.max_velocity_scaling_factor),
        max_acceleration_scaling_factor=float(message.max_acceleration_scaling_factor),
        max_cartesian_speed=float(message.max_cartesian_speed),
        cartesian_speed_limited_link=message.cartesian_speed_limited_link,
        workspace=_workspace(message.workspace_parameters),
        has_trajectory_constraints=bool(message.trajectory_constraints.constraints),
        seed=seed)


def error_code_message(code: int, text: str = '', source: str = '') -> MoveItErrorCodes:
    """Return the message of an error code."""
    return MoveItErrorCodes(val=int(code), message=text, source=source)


def robot_trajectory_message(trajectory: JointTrajectory, frame_id: str) -> RobotTrajectory:
    """Return a trajectory's message; ``frame_id`` is the model frame."""
    message = RobotTrajectory(joint_trajectory=trajectory_to_message(trajectory))
    message.joint_trajectory.header.frame_id = frame_id
    return message


def display_trajectory_message(
    model_id: str, trajectories: Sequence[RobotTrajectory], start: RobotState
) -> DisplayTrajectory:
    """Return what RViz animates: trajectories and the full state that the first begins with."""
    return DisplayTrajectory(
        model_id=model_id, trajectory=list(trajectories), trajectory_start=start)


def _workspace(message: WorkspaceMessage) -> WorkspaceParameters:
    low, high = message.min_corner, message.max_corner
    return WorkspaceParameters(
        frame_id=message.header.frame_id, min_corner=(float(low.x), float(low.y), float(low.z)),
        max_corner=(float(high.x), float(high.y), float(high.z)))
