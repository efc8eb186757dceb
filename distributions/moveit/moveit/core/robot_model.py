# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The names of ``moveit.core.robot_model``."""

from armsim_ros.moveit_py.robot_model import JointModelGroup, RobotModel, VariableBounds

__all__ = ['JointModelGroup', 'RobotModel', 'VariableBounds']
