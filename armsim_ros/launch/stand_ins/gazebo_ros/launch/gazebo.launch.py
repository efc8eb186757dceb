# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Gazebo classic; replaced by the simulation."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.conditions import IfCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution, ThisLaunchFileDir

PARTS = {'gzserver': 'server', 'gzclient': 'gui'}


def generate_launch_description():
    """Return server and window."""
    return LaunchDescription([
        *(DeclareLaunchArgument(name, default_value='true') for name in PARTS.values()),
        *(IncludeLaunchDescription(
            PythonLaunchDescriptionSource(
                PathJoinSubstitution([ThisLaunchFileDir(), f'{part}.launch.py'])),
            condition=IfCondition(LaunchConfiguration(name))) for part, name in PARTS.items()),
    ])
