# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The arm as a Gymnasium environment for learning and for data.

``gymnasium.make('armsim_ros.env:armsim/Arm-v0', robot='sunday')`` works, too. It needs Gymnasium:
``pip install 'armsim_ros[gym]'``.
"""

import os
import sys

if 'mujoco' not in sys.modules and not os.environ.get('DISPLAY'):
    os.environ.setdefault('MUJOCO_GL', 'egl')  # how pictures are drawn; read with MuJoCo's import

from gymnasium import register

from armsim_ros.env.arm_env import ArmEnv
from armsim_ros.env.options import EnvState
from armsim_ros.env.vector import ArmVectorEnv

__all__ = ['ArmEnv', 'ArmVectorEnv', 'EnvState']

register('armsim/Arm-v0', entry_point='armsim_ros.env.arm_env:ArmEnv')
