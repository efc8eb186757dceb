# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Gazebo's server and the bridge of topics; replaced by the simulation."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution, ThisLaunchFileDir
from launch_ros.actions import Node


def generate_launch_description():
    """Return the server, and the bridge."""
    server = PathJoinSubstitution([ThisLaunchFileDir(), 'gz_server.launch.py'])
    return LaunchDescription([
        DeclareLaunchArgument('bridge_name', default_value='ros_gz_bridge'),
        DeclareLaunchArgument('config_file', default_value=''),
        IncludeLaunchDescription(PythonLaunchDescriptionSource(server)),
        Node(package='ros_gz_bridge', executable='parameter_bridge', output='screen',
             name=LaunchConfiguration('bridge_name')),
    ])
