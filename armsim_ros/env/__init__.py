# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The arm as an environment for learning and for data.

With Gymnasium, ``gymnasium.make('armsim_ros.env:armsim/Arm-v0', robot='sunday')`` works, too.
"""

import os
import sys

if 'mujoco' not in sys.modules and not os.environ.get('DISPLAY'):
    os.environ.setdefault('MUJOCO_GL', 'egl')  # how pictures are drawn; read with MuJoCo's import

from armsim_ros.env.arm_env import ArmEnv, EnvState
from armsim_ros.env.gym_base import HAS_GYMNASIUM
from armsim_ros.env.vector import ProcessVector

__all__ = ['ArmEnv', 'EnvState', 'ProcessVector']

if HAS_GYMNASIUM:
    from gymnasium import register

    register('armsim/Arm-v0', entry_point='armsim_ros.env.arm_env:ArmEnv')
