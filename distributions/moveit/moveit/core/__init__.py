# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The modules of ``moveit.core``."""

from armsim_ros.moveit_py.scene_parts import World
from moveit.core import (
    collision_detection,
    controller_manager,
    kinematic_constraints,
    planning_interface,
    planning_scene,
    robot_model,
    robot_state,
    robot_trajectory,
)

__all__ = [
    'World',
    'collision_detection',
    'controller_manager',
    'kinematic_constraints',
    'planning_interface',
    'planning_scene',
    'robot_model',
    'robot_state',
    'robot_trajectory',
]
