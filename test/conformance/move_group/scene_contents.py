# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a message that is refused must leave as it is."""

from __future__ import annotations

from typing import Any


def contents(arm: Any) -> Any:
    """
    Return all that a refused message must leave as it is.

    Frames on a link go on to settle, and with them the last digits of what is put onto a link.
    """
    scene = arm.scene()
    attached = scene.robot_state.attached_collision_objects
    for pose in (item.object.pose for item in attached):
        for part in (pose.position, pose.orientation):
            for field in part.get_fields_and_field_types():
                setattr(part, field, round(getattr(part, field), 9) + 0.0)
    return (
        scene.world, scene.allowed_collision_matrix, scene.link_padding, scene.link_scale,
        scene.object_colors, attached,
        [(one.header.frame_id, one.child_frame_id) for one in scene.fixed_frame_transforms],
    )
