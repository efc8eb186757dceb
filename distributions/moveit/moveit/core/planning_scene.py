# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The names of ``moveit.core.planning_scene``."""

from armsim_ros.moveit_py.planning_scene import PlanningScene

__all__ = ['PlanningScene']
