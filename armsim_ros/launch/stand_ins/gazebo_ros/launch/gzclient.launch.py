# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Gazebo classic's window, which the simulation does not have."""

from launch import LaunchDescription
from launch_ros.actions import Node


def generate_launch_description():
    """Return the window."""
    return LaunchDescription([Node(package='gazebo_ros', executable='gzclient')])
