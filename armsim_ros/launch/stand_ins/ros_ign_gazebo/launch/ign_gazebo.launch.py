# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Ignition Gazebo by its usual arguments; replaced by the simulation."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration

ARGUMENTS = {'ign_args': '', 'ign_version': '6', 'gz_args': '', 'debugger': 'false'}


def generate_launch_description():
    """Return a process."""
    return LaunchDescription([
        *(DeclareLaunchArgument(name, default_value=value) for name, value in ARGUMENTS.items()),
        ExecuteProcess(cmd=[['ign gazebo ', LaunchConfiguration('ign_args'), ' ',
                             LaunchConfiguration('gz_args')]],
                       shell=True, name='gazebo', output='screen'),
    ])
