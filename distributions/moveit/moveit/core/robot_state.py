# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The names of ``moveit.core.robot_state``."""

from armsim_ros.moveit_py.robot_state import RobotState, robotStateToRobotStateMsg

__all__ = ['RobotState', 'robotStateToRobotStateMsg']
