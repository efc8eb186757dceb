# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The names of ``moveit.core.collision_detection``."""

from armsim_ros.moveit_py.scene_parts import (
    AllowedCollisionMatrix,
    CollisionRequest,
    CollisionResult,
)

__all__ = ['AllowedCollisionMatrix', 'CollisionRequest', 'CollisionResult']
