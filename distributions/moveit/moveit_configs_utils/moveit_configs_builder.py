# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The names of ``moveit_configs_utils.moveit_configs_builder``."""

from armsim_ros.launch.api.moveit_configs import MoveItConfigs, MoveItConfigsBuilder

__all__ = ['MoveItConfigs', 'MoveItConfigsBuilder']
