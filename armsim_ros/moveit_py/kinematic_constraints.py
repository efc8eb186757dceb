# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``moveit.core.kinematic_constraints``: goals as messages."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from geometry_msgs.msg import Pose
from moveit_msgs.msg import (
    BoundingVolume,
    Constraints,
    JointConstraint,
    OrientationConstraint,
    PositionConstraint,
)
from shape_msgs.msg import SolidPrimitive

from armsim_ros.model.transforms import quat_xyzw_from_rpy
from armsim_ros.moveit_py.robot_model import JointModelGroup
from armsim_ros.moveit_py.robot_state import RobotState


def construct_joint_constraint(
    robot_state: RobotState, joint_model_group: JointModelGroup, tolerance: float = 0.01
) -> Constraints:
    """
    Return constraints that keep a group's joints where a state has them.

    :param tolerance: to either side [rad or m].
    """
    positions = robot_state.joint_positions
    return Constraints(joint_constraints=[
        JointConstraint(
            joint_name=name, position=positions[name], tolerance_above=float(tolerance),
            tolerance_below=float(tolerance), weight=1.0)
        for name in joint_model_group.active_joint_model_names])


def construct_link_constraint(
    link_name: str, source_frame: str, cartesian_position: Sequence[float] | None = None,
    cartesian_position_tolerance: float | None = None, orientation: Sequence[float] | None = None,
    orientation_tolerance: float | None = None
) -> Constraints:
    """
    Return constraints on the position of a link, its orientation, or both.

    :param source_frame: the frame of position and orientation.
    :param cartesian_position: (3,) [m].
    :param cartesian_position_tolerance: radius of a sphere [m].
    :param orientation: (4,) quaternion x, y, z, w.
    :param orientation_tolerance: about each axis [rad].
    :raises ValueError: neither is given, or its tolerance is missing.
    """
    if cartesian_position is None and orientation is None:
        raise ValueError('no constraint: give cartesian_position, orientation, or both')
    made = Constraints()
    if cartesian_position is not None:
        if cartesian_position_tolerance is None:
            raise ValueError('cartesian_position needs cartesian_position_tolerance [m]')
        x, y, z = map(float, cartesian_position)
        made.position_constraints = [_position(
            link_name, source_frame, (x, y, z), float(cartesian_position_tolerance))]
    if orientation is not None:
        if orientation_tolerance is None:
            raise ValueError('orientation needs orientation_tolerance [rad]')
        made.orientation_constraints = [_orientation(
            link_name, source_frame, orientation, float(orientation_tolerance))]
    return made


def pose_constraint(
    link_name: str, frame: str, pose: Pose, position_tolerance: float, orientation_tolerance: float
) -> Constraints:
    """Return constraints on the pose of a link, with tolerances [m] and [rad]."""
    place, turn = pose.position, pose.orientation
    return construct_link_constraint(
        link_name, frame, (place.x, place.y, place.z), position_tolerance,
        (turn.x, turn.y, turn.z, turn.w), orientation_tolerance)


def _position(
    link: str, frame: str, point: tuple[float, float, float], tolerance: float
) -> PositionConstraint:
    made = PositionConstraint(link_name=link, weight=1.0)
    made.header.frame_id = frame
    pose = Pose()
    pose.position.x, pose.position.y, pose.position.z = point
    made.constraint_region = BoundingVolume(
        primitives=[SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[tolerance])],
        primitive_poses=[pose])
    return made


def _orientation(
    link: str, frame: str, xyzw: Sequence[float], tolerance: float
) -> OrientationConstraint:
    made = OrientationConstraint(link_name=link, weight=1.0)
    made.header.frame_id = frame
    turn = made.orientation
    turn.x, turn.y, turn.z, turn.w = map(float, xyzw)
    made.absolute_x_axis_tolerance = made.absolute_y_axis_tolerance = tolerance
    made.absolute_z_axis_tolerance = tolerance
    return made


def construct_constraints_from_node(node_name: Any, ns: str) -> Constraints:
    """
    Return the constraints that the parameters of a node describe.

    The list ``<ns>.constraint_ids`` names blocks with ``type``: joint (``joint_name``,
    ``position`` or ``bounds``), position (``frame_id``, ``link_name``, ``region.x``,
    ``region.y``, ``region.z``: a least and a largest value each) or orientation
    (``frame_id``, ``link_name``, ``orientation``: three angles; ``tolerances``).

    :param node_name: a node of rclpy.
    :param ns: prefix of the parameters.
    :raises ValueError: a block has another type.
    """
    def value(name: str, default: Any = None) -> Any:
        path = f'{ns}.{name}' if ns else name
        return node_name.get_parameter(path).value if node_name.has_parameter(path) else default

    made = Constraints(name=str(value('name', '')))
    add: Mapping[str, Any] = {
        'joint': (made.joint_constraints, _joint_of_node),
        'position': (made.position_constraints, _position_of_node),
        'orientation': (made.orientation_constraints, _orientation_of_node),
    }
    for key in value('constraint_ids', []):
        base = f'constraints.{key}'
        kind = value(f'{base}.type')
        if kind not in add:
            raise ValueError(f"{ns}.{base}.type is '{kind}'; allowed: {', '.join(add)}")
        target, read = add[kind]
        target.append(read(lambda name, default=None, base=base: value(f'{base}.{name}', default)))
    return made


def _joint_of_node(value: Any) -> JointConstraint:
    low, high = value('bounds', (None, None))
    if low is not None:
        middle = 0.5 * (low + high)
        return JointConstraint(
            joint_name=value('joint_name'), position=middle, tolerance_above=high - middle,
            tolerance_below=middle - low, weight=float(value('weight', 1.0)))
    tolerance = float(value('tolerance', 1e-16))
    return JointConstraint(
        joint_name=value('joint_name'), position=float(value('position')),
        tolerance_above=tolerance, tolerance_below=tolerance, weight=float(value('weight', 1.0)))


def _position_of_node(value: Any) -> PositionConstraint:
    ends = [value(f'region.{axis}') for axis in 'xyz']
    x, y, z = (0.5 * (low + high) for low, high in ends)
    made = _position(value('link_name'), value('frame_id'), (x, y, z), 0.0)
    made.constraint_region.primitives = [SolidPrimitive(
        type=SolidPrimitive.BOX, dimensions=[high - low for low, high in ends])]
    return made


def _orientation_of_node(value: Any) -> OrientationConstraint:
    made = _orientation(value('link_name'), value('frame_id'),
                        quat_xyzw_from_rpy(value('orientation')).tolist(), 0.0)
    (made.absolute_x_axis_tolerance, made.absolute_y_axis_tolerance,
     made.absolute_z_axis_tolerance) = map(float, value('tolerances'))
    return made
