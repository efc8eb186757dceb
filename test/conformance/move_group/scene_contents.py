# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a message that is refused must leave as it is."""

from __future__ import annotations

from typing import Any


def contents(arm: Any) -> Any:
    """Return all that a refused message must leave as it is; frames on a link go on to settle."""
    scene = arm.scene()
    return (
        scene.world, scene.allowed_collision_matrix, scene.link_padding, scene.link_scale,
        scene.object_colors, scene.robot_state.attached_collision_objects,
        [(one.header.frame_id, one.child_frame_id) for one in scene.fixed_frame_transforms],
    )
