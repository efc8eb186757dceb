# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""MoveIt's configurations for scripts, answered by armsim_ros."""

from armsim_ros.launch.api.moveit_configs import MoveItConfigs, MoveItConfigsBuilder

__all__ = ['MoveItConfigs', 'MoveItConfigsBuilder']
