# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The names of ``moveit.core.robot_trajectory``."""

from armsim_ros.moveit_py.robot_trajectory import RobotTrajectory

__all__ = ['RobotTrajectory']
