# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The launch descriptions that MoveIt's setup assistant puts into its packages."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from armsim_ros.launch.api.actions.configuration import DeclareLaunchArgument
from armsim_ros.launch.api.conditions import IfCondition
from armsim_ros.launch.api.description import LaunchDescription
from armsim_ros.launch.api.include import AnyLaunchDescriptionSource, IncludeLaunchDescription
from armsim_ros.launch.api.moveit.launch_utils import (
    add_debuggable_node,
    DeclareBooleanLaunchArg,
)
from armsim_ros.launch.api.ros_node import Node
from armsim_ros.launch.api.ros_parameters import ParameterValue
from armsim_ros.launch.api.substitutions.texts import LaunchConfiguration
from armsim_ros.model.description.xml_tree import parse_xml

#: The launch files that a demo consists of, with the argument that each depends on.
_DEMO = (('static_virtual_joint_tfs', None), ('rsp', None), ('move_group', None),
         ('moveit_rviz', 'use_rviz'), ('warehouse_db', 'db'))


def generate_rsp_launch(moveit_config: Any) -> LaunchDescription:
    """Return a robot_state_publisher."""
    return LaunchDescription([
        DeclareLaunchArgument('publish_frequency', default_value='15.0'),
        Node(package='robot_state_publisher', executable='robot_state_publisher', respawn=True,
             output='screen', parameters=[
                 moveit_config.robot_description,
                 {'publish_frequency': LaunchConfiguration('publish_frequency')}]),
    ])


def generate_moveit_rviz_launch(moveit_config: Any) -> LaunchDescription:
    """Return RViz with MoveIt's panel."""
    view = str(Path(moveit_config.package_path) / 'config' / 'moveit.rviz')
    made = LaunchDescription([
        DeclareBooleanLaunchArg('debug', default_value=False),
        DeclareLaunchArgument('rviz_config', default_value=view),
    ])
    add_debuggable_node(
        made, package='rviz2', executable='rviz2', output='log', respawn=False,
        arguments=['-d', LaunchConfiguration('rviz_config')],
        parameters=[moveit_config.planning_pipelines,
                    moveit_config.robot_description_kinematics, moveit_config.joint_limits])
    return made


def generate_setup_assistant_launch(moveit_config: Any) -> LaunchDescription:
    """Return the setup assistant."""
    made = LaunchDescription([DeclareBooleanLaunchArg('debug', default_value=False)])
    add_debuggable_node(
        made, package='moveit_setup_assistant', executable='moveit_setup_assistant',
        arguments=[['--config_pkg=', str(moveit_config.package_path)]])
    return made


def generate_static_virtual_joint_tfs_launch(moveit_config: Any) -> LaunchDescription:
    """Return a static transform for each virtual joint of the SRDF."""
    made = LaunchDescription()
    for name, text in moveit_config.robot_description_semantic.items():
        if not isinstance(text, str):
            continue
        for number, joint in enumerate(parse_xml(text, name).all('virtual_joint')):
            made.add_action(Node(
                package='tf2_ros', executable='static_transform_publisher',
                name=f'static_transform_publisher{number}', output='log',
                arguments=['--frame-id', joint.get('parent_frame'),
                           '--child-frame-id', joint.get('child_link')]))
    return made


def generate_spawn_controllers_launch(moveit_config: Any) -> LaunchDescription:
    """Return a spawner for each controller of move_group, and the broadcaster's."""
    manager = moveit_config.trajectory_execution.get('moveit_simple_controller_manager', {})
    names = [*manager.get('controller_names', ()), 'joint_state_broadcaster']
    return LaunchDescription([Node(package='controller_manager', executable='spawner',
                                   arguments=[name], output='screen') for name in names])


def generate_warehouse_db_launch(moveit_config: Any) -> LaunchDescription:
    """Return the database of MoveIt's warehouse."""
    folder = str(Path(moveit_config.package_path) / 'default_warehouse_mongo_db')
    return LaunchDescription([
        DeclareLaunchArgument('moveit_warehouse_database_path', default_value=folder),
        DeclareBooleanLaunchArg('reset', default_value=False),
        DeclareLaunchArgument('moveit_warehouse_port', default_value='33829'),
        DeclareLaunchArgument('moveit_warehouse_host', default_value='localhost'),
        Node(package='warehouse_ros_mongo', executable='mongo_wrapper_ros.py', parameters=[{
            'overwrite': False,
            'database_path': LaunchConfiguration('moveit_warehouse_database_path'),
            'warehouse_port': LaunchConfiguration('moveit_warehouse_port'),
            'warehouse_host': LaunchConfiguration('moveit_warehouse_host'),
            'warehouse_exec': 'mongod',
            'warehouse_plugin': 'warehouse_ros_mongo::MongoDatabaseConnection'}]),
        Node(package='moveit_ros_warehouse', executable='moveit_init_demo_warehouse',
             output='screen', condition=IfCondition(LaunchConfiguration('reset'))),
    ])


def generate_move_group_launch(moveit_config: Any) -> LaunchDescription:
    """Return a move_group."""
    capabilities = moveit_config.move_group_capabilities
    made = LaunchDescription([
        DeclareBooleanLaunchArg('debug', default_value=False),
        DeclareBooleanLaunchArg('allow_trajectory_execution', default_value=True),
        DeclareBooleanLaunchArg('publish_monitored_planning_scene', default_value=True),
        *(DeclareLaunchArgument(name, default_value=capabilities[name])
          for name in ('capabilities', 'disable_capabilities')),
        DeclareBooleanLaunchArg('monitor_dynamics', default_value=False),
    ])
    published = LaunchConfiguration('publish_monitored_planning_scene')
    settings = {
        'publish_robot_description_semantic': True,
        'allow_trajectory_execution': LaunchConfiguration('allow_trajectory_execution'),
        'monitor_dynamics': False,
        **{name: ParameterValue(LaunchConfiguration(name), value_type=str)
           for name in ('capabilities', 'disable_capabilities')},
        **{f'publish_{name}': published for name in (
            'planning_scene', 'geometry_updates', 'state_updates', 'transforms_updates')},
    }
    commands = str(Path(moveit_config.package_path) / 'launch' / 'gdb_settings.gdb')
    add_debuggable_node(
        made, package='moveit_ros_move_group', executable='move_group', output='screen',
        commands_file=commands, extra_debug_args=['--debug'],
        parameters=[moveit_config.to_dict(), settings])
    return made


def generate_demo_launch(moveit_config: Any, launch_package_path: Any = None
                         ) -> LaunchDescription:
    """Return all that a simulated robot with MoveIt needs."""
    package = Path(moveit_config.package_path)
    folder = Path(launch_package_path or package) / 'launch'
    made = LaunchDescription([
        DeclareBooleanLaunchArg('db', default_value=False),
        DeclareBooleanLaunchArg('debug', default_value=False),
        DeclareBooleanLaunchArg('use_rviz', default_value=True),
    ])
    for name, argument in _DEMO:
        file = folder / f'{name}.launch.py'
        if name == 'static_virtual_joint_tfs' and not file.exists():
            continue
        made.add_action(IncludeLaunchDescription(
            AnyLaunchDescriptionSource(str(file)),
            condition=IfCondition(LaunchConfiguration(argument)) if argument else None))
    made.add_action(Node(
        package='controller_manager', executable='ros2_control_node',
        parameters=[str(package / 'config' / 'ros2_controllers.yaml')],
        remappings=[('/controller_manager/robot_description', '/robot_description')]))
    made.add_action(IncludeLaunchDescription(
        AnyLaunchDescriptionSource(str(folder / 'spawn_controllers.launch.py'))))
    return made
