# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What a client asks of motion planning, and the answer: plain values.

The content of ``moveit_msgs``' ``MotionPlanRequest``, ``MotionPlanResponse``, ``Constraints``,
``RobotState`` and ``GetCartesianPath``. Values are as the client gave them; what is wrong with
them is found where they are used. Poses are homogeneous (4, 4) matrices; an empty frame name is
the model frame.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import MoveItErrorCode
from armsim_ros.model.geometry import (
    bounding_box,
    Geometry,
    is_inside,
    nearest_inside,
    shape_fault,
    Sphere,
)
from armsim_ros.model.transforms import inverse_pose, quat_xyzw_from_matrix
from armsim_ros.planning.collision.contacts import Contact
from armsim_ros.planning.scene.update import StartState
from armsim_ros.trajectory import JointTrajectory

FARTHEST = 1e6
"""Numbers beyond this [m] are not places."""

JOINT_TOLERANCE, POSITION_TOLERANCE, ORIENTATION_TOLERANCE = 1e-4, 1e-3, 1e-2
"""Tolerances of goals that are made of numbers: [rad or m], [m], [rad]."""


def is_place(values: Vector) -> bool:
    """Return whether all numbers of a pose or point are finite and not out of this world."""
    return bool(np.all(np.isfinite(values)) and np.all(np.abs(values) <= FARTHEST))


@dataclass(frozen=True, slots=True)
class JointConstraint:
    """
    A joint's position stays in ``position - tolerance_below .. position + tolerance_above``.

    :param position: [rad or m]; so are the tolerances.
    """

    joint_name: str
    position: float
    tolerance_above: float = 0.0
    tolerance_below: float = 0.0
    weight: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """A shape and its pose (4, 4) in the frame of the constraint that it belongs to."""

    shape: Geometry
    pose: Matrix

    @property
    def fault(self) -> str:
        """What is wrong with it, as a phrase, or ''."""
        if not is_place(self.pose):
            return 'its pose has a number that is not finite or too large'
        return shape_fault(self.shape)

    @property
    def center(self) -> Vector:
        """Its middle (3,) [m] in the frame of its pose."""
        return self._out(bounding_box(self.shape)[0])

    @property
    def size(self) -> float:
        """About how far [m] a point of it may be from its middle."""
        return float(np.linalg.norm(bounding_box(self.shape)[1]))

    def outside_by(self, point: Vector, margin: float = 0.0) -> Vector:
        """
        Return the way (3,) [m] from the region to a point that lies outside, zeros inside.

        :param point: (3,) [m] in the frame that the region's pose is given in.
        :param margin: share 0..1 by which the region is smaller than given.
        """
        local = (inverse_pose(self.pose) @ np.append(point, 1.0))[:3]
        way: Vector = self.pose[:3, :3] @ (local - nearest_inside(self.shape, local, margin))
        return way

    def random_point(self, rng: np.random.Generator) -> Vector:
        """
        Return a random point (3,) [m] of the region in the frame of its pose.

        Drawn evenly from the shape's box until a point is inside, at most 100 times; then the
        centre.
        """
        middle, half = bounding_box(self.shape)
        for _ in range(100):
            point = middle + rng.uniform(-half, half)
            if is_inside(self.shape, point):
                return self._out(point)
        return self.center

    def _out(self, point: Vector) -> Vector:
        moved: Vector = (self.pose @ np.append(point, 1.0))[:3]
        return moved


@dataclass(frozen=True, slots=True, eq=False)
class PositionConstraint:
    """
    A point of a link stays in one of several regions.

    :param frame_id: frame of the regions.
    :param regions: one is enough.
    :param target_point_offset: (3,) the point [m] in the link's frame.
    :param left_out: why further regions of a message cannot be used.
    :param primitive_poses: (4, 4) each, also of primitives without a shape, which PTP, LIN and
        CIRC do not need; None for those of the regions.
    """

    link_name: str
    regions: tuple[Region, ...]
    frame_id: str = ''
    target_point_offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    weight: float = 1.0
    left_out: tuple[str, ...] = ()
    primitive_poses: tuple[Matrix, ...] | None = None

    @property
    def poses(self) -> tuple[Matrix, ...]:
        """The poses (4, 4) of the primitives."""
        if self.primitive_poses is None:
            return tuple(region.pose for region in self.regions)
        return self.primitive_poses


class Parameterization(IntEnum):
    """How an orientation error is split into three angles."""

    XYZ_EULER_ANGLES = 0
    ROTATION_VECTOR = 1


@dataclass(frozen=True, slots=True)
class OrientationConstraint:
    """
    A link's orientation stays near a given orientation.

    :param quat_xyzw: the orientation in ``frame_id``.
    :param tolerances: (x, y, z) [rad], each the largest absolute error; about the axes of the
        orientation as XYZ_EULER_ANGLES, of ``frame_id`` as ROTATION_VECTOR.
    :param parameterization: a value of :class:`Parameterization`.
    """

    link_name: str
    quat_xyzw: tuple[float, float, float, float]
    tolerances: tuple[float, float, float] = (0.0, 0.0, 0.0)
    frame_id: str = ''
    parameterization: int = Parameterization.XYZ_EULER_ANGLES
    weight: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class VisibilityConstraint:
    """
    A disc is visible to a sensor: it faces the sensor, and no link is in the cone in between.

    :param target_radius: of the disc in the x-y plane of its pose [m]; 0: the cone may be blocked.
    :param target_pose: (4, 4) in ``target_frame_id``; z points to the sensor.
    :param sensor_pose: (4, 4) in ``sensor_frame_id``.
    :param cone_sides: number of sides of the cone, at least 3.
    :param max_view_angle: largest angle between the view direction and -z of the disc [rad]; 0:
        any.
    :param max_range_angle: largest angle between the view direction and the way to the disc
        [rad]; 0: any.
    :param sensor_view_direction: the axis of view: 0 is z, 1 is y, 2 is x.
    """

    target_radius: float
    target_pose: Matrix
    target_frame_id: str
    sensor_pose: Matrix
    sensor_frame_id: str
    cone_sides: int = 3
    max_view_angle: float = 0.0
    max_range_angle: float = 0.0
    sensor_view_direction: int = 0


@dataclass(frozen=True, slots=True)
class Constraints:
    """All of these at once."""

    joint_constraints: tuple[JointConstraint, ...] = ()
    position_constraints: tuple[PositionConstraint, ...] = ()
    orientation_constraints: tuple[OrientationConstraint, ...] = ()
    visibility_constraints: tuple[VisibilityConstraint, ...] = ()
    name: str = ''

    @classmethod
    def of_joints(
        cls, positions: Mapping[str, float], tolerance: float = JOINT_TOLERANCE
    ) -> Constraints:
        """
        Return a goal in joint space.

        :param positions: joint -> [rad or m].
        :param tolerance: to either side [rad or m].
        """
        return cls(tuple(
            JointConstraint(name, position, tolerance, tolerance)
            for name, position in positions.items()))

    @classmethod
    def of_pose(
        cls, link_name: str, pose: Matrix, frame_id: str = '', *,
        position_tolerance: float = POSITION_TOLERANCE,
        orientation_tolerance: float = ORIENTATION_TOLERANCE,
    ) -> Constraints:
        """
        Return a goal for the pose of a link.

        :param pose: (4, 4) in the frame.
        :param frame_id: a link, an object or the model frame, which has to be named.
        :param position_tolerance: radius of a sphere [m].
        :param orientation_tolerance: about each axis [rad].
        """
        x, y, z, w = quat_xyzw_from_matrix(pose).tolist()
        region = Region(Sphere(position_tolerance), pose)
        return cls(
            position_constraints=(PositionConstraint(link_name, (region,), frame_id),),
            orientation_constraints=(OrientationConstraint(
                link_name, (x, y, z, w), (orientation_tolerance,) * 3, frame_id,
                Parameterization.ROTATION_VECTOR),))

    @property
    def empty(self) -> bool:
        """Whether nothing is asked."""
        return not (
            self.joint_constraints
            or self.position_constraints
            or self.orientation_constraints
            or self.visibility_constraints)


@dataclass(frozen=True, slots=True)
class WorkspaceParameters:
    """
    A box for planar and floating joints; it does not limit a fixed arm.

    :param min_corner: (3,) [m].
    :param max_corner: (3,) [m].
    """

    frame_id: str = ''
    min_corner: tuple[float, float, float] = (0.0, 0.0, 0.0)
    max_corner: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class MotionPlanRequest:
    """
    A motion for a planning group.

    :param goal_constraints: alternatives; one of them is enough.
    :param path_constraints: hold at every state of the path.
    :param pipeline_id: '' for the default pipeline.
    :param planner_id: '' for the group's default planner.
    :param allowed_planning_time: [s] for the search.
    :param max_velocity_scaling_factor: 0..1; anything else counts as 1.
    :param max_acceleration_scaling_factor: 0..1; anything else counts as 1.
    :param max_cartesian_speed: [m/s] of ``cartesian_speed_limited_link``; 0 for no limit.
    :param seed: a number >= 0 makes the search repeatable.
    """

    group_name: str
    goal_constraints: tuple[Constraints, ...] = ()
    start_state: StartState = field(default_factory=StartState)
    path_constraints: Constraints = field(default_factory=Constraints)
    pipeline_id: str = ''
    planner_id: str = ''
    num_planning_attempts: int = 1
    allowed_planning_time: float = 5.0
    max_velocity_scaling_factor: float = 1.0
    max_acceleration_scaling_factor: float = 1.0
    max_cartesian_speed: float = 0.0
    cartesian_speed_limited_link: str = ''
    workspace: WorkspaceParameters = field(default_factory=WorkspaceParameters)
    has_trajectory_constraints: bool = False
    seed: int = -1


@dataclass(frozen=True, slots=True)
class MotionPlanResponse:
    """
    The answer to a :class:`MotionPlanRequest`.

    :param error_code: SUCCESS, or what went wrong.
    :param message: a sentence for the user; '' on success.
    :param source: the stage that found it.
    :param trajectory: empty unless it succeeded.
    :param trajectory_start: joint -> position [rad or m] of all movable joints.
    :param planning_time: [s] search and shortening.
    :param path_length: [rad or m] sum of the joint-space distances along the path.
    :param contacts: what touches in the start or goal that was refused for it.
    """

    error_code: MoveItErrorCode
    message: str = ''
    source: str = ''
    trajectory: JointTrajectory = field(default_factory=lambda: JointTrajectory(()))
    trajectory_start: Mapping[str, float] = field(default_factory=dict)
    group_name: str = ''
    planning_time: float = 0.0
    path_length: float = 0.0
    contacts: tuple[Contact, ...] = ()

    @property
    def success(self) -> bool:
        """Whether there is a trajectory."""
        return self.error_code == MoveItErrorCode.SUCCESS


@dataclass(frozen=True, slots=True, eq=False)
class CartesianRequest:
    """
    A path through poses of a link.

    :param waypoints: (4, 4) each in ``frame_id``; where that is the link itself, each is
        relative to the link's pose at the end of the segment before.
    :param link_name: '' for the group's last link.
    :param max_step: [m] between two states of the path.
    """

    group_name: str
    waypoints: tuple[Matrix, ...]
    max_step: float
    link_name: str = ''
    frame_id: str = ''
    start_state: StartState = field(default_factory=StartState)
    avoid_collisions: bool = True
    path_constraints: Constraints = field(default_factory=Constraints)
    max_velocity_scaling_factor: float = 1.0
    max_acceleration_scaling_factor: float = 1.0
    cartesian_speed_limited_link: str = ''
    max_cartesian_speed: float = 0.0


@dataclass(frozen=True, slots=True)
class CartesianResponse:
    """
    The answer to a :class:`CartesianRequest`.

    :param message: why the path ends early or is missing, else ''.
    :param fraction: covered part of the path, 0..1.
    :param start: joint -> position [rad or m] of all movable joints.
    """

    error_code: MoveItErrorCode
    message: str = ''
    source: str = ''
    trajectory: JointTrajectory = field(default_factory=lambda: JointTrajectory(()))
    fraction: float = 0.0
    start: Mapping[str, float] = field(default_factory=dict)
