# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The names of ``moveit_configs_utils.launch_utils``."""

from armsim_ros.launch.api.launches import add_debuggable_node, DeclareBooleanLaunchArg

__all__ = ['DeclareBooleanLaunchArg', 'add_debuggable_node']
