# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The names of ``moveit_configs_utils.launches``."""

from armsim_ros.launch.api.launches import (
    generate_demo_launch,
    generate_move_group_launch,
    generate_moveit_rviz_launch,
    generate_rsp_launch,
    generate_setup_assistant_launch,
    generate_spawn_controllers_launch,
    generate_static_virtual_joint_tfs_launch,
    generate_warehouse_db_launch,
)

__all__ = [
    'generate_demo_launch',
    'generate_move_group_launch',
    'generate_moveit_rviz_launch',
    'generate_rsp_launch',
    'generate_setup_assistant_launch',
    'generate_spawn_controllers_launch',
    'generate_static_virtual_joint_tfs_launch',
    'generate_warehouse_db_launch',
]
