# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``moveit_msgs/msg/Constraints`` to the core's constraints."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from geometry_msgs.msg import Pose
from moveit_msgs.msg import Constraints as ConstraintsMessage
from moveit_msgs.msg import OrientationConstraint as OrientationConstraintMessage
from moveit_msgs.msg import PositionConstraint as PositionConstraintMessage
from shape_msgs.msg import Mesh

from armsim_ros.model.geometry import Geometry
from armsim_ros.nodes.conversions.geometry import (
    mesh_from_message,
    missing_primitive,
    pose_from_message,
    primitive_from_message,
)
from armsim_ros.planning.request import (
    Constraints,
    JointConstraint,
    OrientationConstraint,
    PositionConstraint,
    Region,
    VisibilityConstraint,
)

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
                joint_name=item.joint_name,
                position=float(item.position),
                tolerance_above=float(item.tolerance_above),
                tolerance_below=float(item.tolerance_below),
                weight=float(item.weight),
            )
            for item in message.joint_constraints
        ),
        position_constraints=tuple(_position(item) for item in message.position_constraints),
        orientation_constraints=tuple(
            _orientation(item) for item in message.orientation_constraints
        ),
        visibility_constraints=tuple(
            VisibilityConstraint(
                target_radius=float(item.target_radius),
                target_pose=pose_from_message(item.target_pose.pose),
                target_frame_id=item.target_pose.header.frame_id,
                sensor_pose=pose_from_message(item.sensor_pose.pose),
                sensor_frame_id=item.sensor_pose.header.frame_id,
                cone_sides=int(item.cone_sides),
                max_view_angle=float(item.max_view_angle),
                max_range_angle=float(item.max_range_angle),
                sensor_view_direction=int(item.sensor_view_direction),
            )
            for item in message.visibility_constraints
        ),
    )


def _position(message: PositionConstraintMessage) -> PositionConstraint:
    volume = message.constraint_region
    left_out: list[str] = []
    regions = [
        *_regions(volume.primitives, volume.primitive_poses, missing_primitive,
                  primitive_from_message, left_out),
        *_regions(volume.meshes, volume.mesh_poses, _missing_mesh, mesh_from_message, left_out)]
    offset = message.target_point_offset
    return PositionConstraint(
        link_name=message.link_name,
        regions=tuple(regions),
        frame_id=message.header.frame_id,
        target_point_offset=(float(offset.x), float(offset.y), float(offset.z)),
        weight=float(message.weight),
        left_out=tuple(left_out),
        primitive_poses=tuple(pose_from_message(pose) for pose in volume.primitive_poses),
    )


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
            float(quaternion.x), float(quaternion.y), float(quaternion.z), float(quaternion.w)
        ),
        tolerances=(
            float(message.absolute_x_axis_tolerance),
            float(message.absolute_y_axis_tolerance),
            float(message.absolute_z_axis_tolerance),
        ),
        frame_id=message.header.frame_id,
        parameterization=int(message.parameterization),
        weight=float(message.weight),
    )
