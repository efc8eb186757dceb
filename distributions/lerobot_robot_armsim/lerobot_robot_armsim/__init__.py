# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
armsim_ros for LeRobot.

LeRobot imports this module and finds the environment ``armsim`` (``--env.type=armsim``), the
robot ``armsim`` (``--robot.type=armsim``), the teleoperators ``armsim_expert`` and
``armsim_joints``, and the camera ``armsim``.
"""

import armsim_ros.tasks  # noqa: F401 - registers armsim/... with Gymnasium
from lerobot_robot_armsim.camera import ArmsimCamera, ArmsimCameraConfig
from lerobot_robot_armsim.environment import ArmsimEnvConfig
from lerobot_robot_armsim.expert import ArmsimExpert, ArmsimExpertConfig
from lerobot_robot_armsim.joints import ArmsimJoints, ArmsimJointsConfig
from lerobot_robot_armsim.robot import Armsim, ArmsimConfig

__all__ = [
    'Armsim', 'ArmsimCamera', 'ArmsimCameraConfig', 'ArmsimConfig', 'ArmsimEnvConfig',
    'ArmsimExpert', 'ArmsimExpertConfig', 'ArmsimJoints', 'ArmsimJointsConfig']
