# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Gazebo classic's server; replaced by the simulation."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    """Return the server."""
    return LaunchDescription([
        DeclareLaunchArgument('world', default_value=''),
        Node(package='gazebo_ros', executable='gzserver', output='screen',
             arguments=[LaunchConfiguration('world')]),
    ])
