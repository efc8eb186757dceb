# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Gazebo by its usual arguments; replaced by the simulation."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, Shutdown
from launch.conditions import IfCondition, UnlessCondition
from launch.substitutions import LaunchConfiguration

ARGUMENTS = {'gz_args': '', 'gz_version': '8', 'ign_args': '', 'ign_version': '',
             'debugger': 'false', 'on_exit_shutdown': 'false'}


def generate_launch_description():
    """Return a process."""
    ends_all = LaunchConfiguration('on_exit_shutdown')
    command = [['gz sim ', LaunchConfiguration('gz_args'), ' ', LaunchConfiguration('ign_args')]]
    return LaunchDescription([
        *(DeclareLaunchArgument(name, default_value=value) for name, value in ARGUMENTS.items()),
        ExecuteProcess(cmd=command, shell=True, name='gazebo', output='screen',
                       condition=UnlessCondition(ends_all)),
        ExecuteProcess(cmd=command, shell=True, name='gazebo', output='screen',
                       on_exit=[Shutdown()], condition=IfCondition(ends_all)),
    ])
