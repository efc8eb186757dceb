# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``moveit_msgs/msg/Constraints`` to the core's constraints."""

from __future__ import annotations

from collections.abc import Sequence

from geometry_msgs.msg import Pose
from moveit_msgs.msg import Constraints as ConstraintsMessage
from moveit_msgs.msg import OrientationConstraint as OrientationConstraintMessage
from moveit_msgs.msg import PositionConstraint as PositionConstraintMessage
import numpy as np

from armsim_ros.model.geometry import Geometry
from armsim_ros.nodes.conversions.geometry import (
    mesh_from_message,
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


def constraints_from_message(message: ConstraintsMessage) -> Constraints:
    """
    Return the constraints of a message as they were given.

    :raises PlanningError: for a region whose shape or pose cannot exist.
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
                target_frame_id=item.target_pose.header.frame_id,
                sensor_frame_id=item.sensor_pose.header.frame_id,
                target_radius=float(item.target_radius),
            )
            for item in message.visibility_constraints
        ),
    )


def _position(message: PositionConstraintMessage) -> PositionConstraint:
    volume = message.constraint_region
    regions = [
        *_regions([primitive_from_message(item) for item in volume.primitives],
                  volume.primitive_poses),
        *_regions([mesh_from_message(item) for item in volume.meshes], volume.mesh_poses),
    ]
    offset = message.target_point_offset
    return PositionConstraint(
        link_name=message.link_name,
        regions=tuple(regions),
        frame_id=message.header.frame_id,
        target_point_offset=(float(offset.x), float(offset.y), float(offset.z)),
        weight=float(message.weight),
    )


def _regions(shapes: Sequence[Geometry], poses: Sequence[Pose]) -> list[Region]:
    given = [pose_from_message(pose) for pose in poses]
    given += [np.eye(4)] * (len(shapes) - len(given))
    return [Region(shape, pose) for shape, pose in zip(shapes, given, strict=False)]


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
