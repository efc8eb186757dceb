# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The bridge of topics, which the simulation publishes itself."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    """Return the bridge."""
    return LaunchDescription([
        DeclareLaunchArgument('bridge_name', default_value='ros_gz_bridge'),
        DeclareLaunchArgument('config_file', default_value=''),
        Node(package='ros_gz_bridge', executable='parameter_bridge', output='screen',
             name=LaunchConfiguration('bridge_name'),
             parameters=[{'config_file': LaunchConfiguration('config_file')}]),
    ])
