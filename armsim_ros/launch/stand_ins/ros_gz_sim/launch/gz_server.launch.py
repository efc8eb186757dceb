# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Gazebo's server; replaced by the simulation."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration

ARGUMENTS = {'world_sdf_file': '', 'world_sdf_string': '', 'container_name': 'ros_gz_container',
             'create_own_container': 'False', 'use_composition': 'False'}


def generate_launch_description():
    """Return a process."""
    return LaunchDescription([
        *(DeclareLaunchArgument(name, default_value=value) for name, value in ARGUMENTS.items()),
        ExecuteProcess(cmd=[['gz sim -s ', LaunchConfiguration('world_sdf_file')]], shell=True,
                       name='gazebo', output='screen'),
    ])
