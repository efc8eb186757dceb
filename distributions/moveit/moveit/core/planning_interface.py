# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The names of ``moveit.core.planning_interface``."""

from armsim_ros.moveit_py.answers import MotionPlanResponse

__all__ = ['MotionPlanResponse']
