# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A script with the configuration of a package."""

import subprocess
import sys

import pytest

pytestmark = pytest.mark.statement('A1', 'A2', 'D1')

SCRIPT = """#!/usr/bin/env python3
import sys

from moveit.core.robot_state import RobotState
from moveit.planning import MoveItPy
from moveit_configs_utils import MoveItConfigsBuilder

config = None
if sys.argv[1:] == ['alone']:
    config = MoveItConfigsBuilder('small').to_moveit_configs().to_dict()
moveit = MoveItPy(node_name='moveit_py', config_dict=config)
arm = moveit.get_planning_component('arm')
arm.set_start_state(robot_state=RobotState(moveit.get_robot_model()))
arm.set_goal_state(configuration_name='bent')
print('planned', bool(arm.plan()))
"""
LAUNCH = """
from launch import LaunchDescription
from launch_ros.actions import Node
from moveit_configs_utils import MoveItConfigsBuilder


def generate_launch_description():
    config = MoveItConfigsBuilder('small').to_moveit_configs()
    return LaunchDescription([Node(
        name='moveit_py', package='small_moveit_config', executable='plan.py', output='both',
        parameters=[config.to_dict()])])
"""


@pytest.mark.parametrize('command', [
    ['-m', 'armsim_ros', 'launch', 'small_moveit_config', 'plan.launch.py'],
    ['repository/small_moveit_config/scripts/plan.py', 'alone']])
def test_a_script_is_started_by_a_launch_file_or_alone(command, small_package):
    """The parameters are those of the launch file, or those that its own builder reads."""
    small_package.write('scripts/plan.py', SCRIPT).chmod(0o755)
    small_package.write('launch/plan.launch.py', LAUNCH)
    done = subprocess.run(
        [sys.executable, *command], cwd=small_package.src, capture_output=True, text=True,
        timeout=60)
    assert done.returncode == 0, done.stderr
    assert 'planned True' in done.stdout, done.stdout + done.stderr
