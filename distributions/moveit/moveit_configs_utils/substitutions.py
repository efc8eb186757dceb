# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The names of ``moveit_configs_utils.substitutions``."""

from armsim_ros.launch.api.launches import Xacro

__all__ = ['Xacro']
