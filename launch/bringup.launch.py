# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Starts the stack: ``ros2 launch armsim_ros bringup.launch.py robot:=sunday``."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, EmitEvent, ExecuteProcess, RegisterEventHandler
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.substitutions import FindPackagePrefix

from armsim_ros.cli.arguments import argument_table, to_word


def generate_launch_description() -> LaunchDescription:
    """Return one process, bringup, with every argument that it has."""
    table = argument_table()
    declared = [
        DeclareLaunchArgument(entry.name, default_value=to_word(entry.default),
                              description=entry.metadata['description'])
        for entry in table]
    program = PathJoinSubstitution(
        [FindPackagePrefix('armsim_ros'), 'lib', 'armsim_ros', 'bringup'])
    bringup = ExecuteProcess(
        cmd=[program, *([f'{entry.name}:=', LaunchConfiguration(entry.name)] for entry in table)],
        name='bringup', output='screen')
    ends_with_it = RegisterEventHandler(OnProcessExit(
        target_action=bringup, on_exit=[EmitEvent(event=Shutdown(reason='bringup has ended'))]))
    return LaunchDescription([*declared, bringup, ends_with_it])
