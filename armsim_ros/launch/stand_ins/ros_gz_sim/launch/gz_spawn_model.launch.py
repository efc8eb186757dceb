# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Spawns a model in the simulation."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

ARGUMENTS = {
    'world': '', 'file': '', 'model_string': '', 'xml_string': '', 'topic': '',
    'entity_name': '', 'allow_renaming': 'False', 'x': '0.0', 'y': '0.0', 'z': '0.0',
    'roll': '0.0', 'pitch': '0.0', 'yaw': '0.0',
}
FLAGS = {'-world': 'world', '-file': 'file', '-string': 'model_string', '-topic': 'topic',
         '-name': 'entity_name', '-x': 'x', '-y': 'y', '-z': 'z', '-R': 'roll', '-P': 'pitch',
         '-Y': 'yaw'}


def generate_launch_description():
    """Return the program that spawns."""
    words = [word for flag, name in FLAGS.items() for word in (flag, LaunchConfiguration(name))]
    return LaunchDescription([
        *(DeclareLaunchArgument(name, default_value=value) for name, value in ARGUMENTS.items()),
        Node(package='ros_gz_sim', executable='create', output='screen', arguments=words),
    ])
