# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The launch descriptions of MoveIt's packages, and controller_manager's helpers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from armsim_ros.install_rules.xacro_run import XacroCommand
from armsim_ros.launch.api.configuration import DeclareLaunchArgument, IfCondition, UnlessCondition
from armsim_ros.launch.api.context import LaunchContext, perform_text, SomeText, Substitution
from armsim_ros.launch.api.description import (
    AnyLaunchDescriptionSource,
    IncludeLaunchDescription,
    LaunchDescription,
)
from armsim_ros.launch.api.programs import PythonExpression, run_xacro
from armsim_ros.launch.api.ros_node import Node
from armsim_ros.launch.api.ros_parameters import ParameterValue
from armsim_ros.launch.api.substitutions import LaunchConfiguration
from armsim_ros.model.description.xml_tree import parse_xml


class Xacro(Substitution):
    """
    The output of xacro for a file.

    :param file_path: of the file.
    :param mappings: its arguments.
    """

    def __init__(self, file_path: SomeText, *, mappings: Mapping[Any, Any] | None = None) -> None:
        self._file = file_path
        self._mappings = dict(mappings or {})

    def perform(self, context: LaunchContext) -> str:
        """Return the robot description."""
        words = {perform_text(context, name): perform_text(context, value)
                 for name, value in self._mappings.items()}
        return run_xacro(XacroCommand(perform_text(context, self._file), words), self.where)


class DeclareBooleanLaunchArg(DeclareLaunchArgument):
    """
    An argument that is true or false.

    :param name: of the argument.
    """

    def __init__(self, name: str, *, default_value: Any = False,
                 description: str | None = None, **kwargs: Any) -> None:
        super().__init__(name, default_value=str(default_value), description=description,
                         choices=['true', 'false', 'True', 'False'], **kwargs)


def add_debuggable_node(
    ld: LaunchDescription, package: SomeText, executable: SomeText,
    condition_name: str = 'debug', commands_file: str | None = None,
    extra_debug_args: Iterable[str] | None = None, **kwargs: Any
) -> None:
    """Add a node, and the same node in a debugger for when an argument asks for it."""
    requested = LaunchConfiguration(condition_name)
    ld.add_action(Node(package=package, executable=executable,
                       condition=UnlessCondition(requested), **kwargs))
    arguments = [*(kwargs.pop('arguments', None) or ()), *(extra_debug_args or ())]
    commands = f'-x {commands_file} ' if commands_file else ''
    ld.add_action(Node(package=package, executable=executable, condition=IfCondition(requested),
                       prefix=[f'gdb {commands}--ex run --args'], arguments=arguments, **kwargs))


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


def generate_demo_launch(moveit_config: Any, launch_package_path: Any = None) -> LaunchDescription:
    """Return all that a simulated robot with MoveIt needs."""
    package = Path(moveit_config.package_path)
    folder = Path(launch_package_path or package) / 'launch'
    made = LaunchDescription([
        DeclareBooleanLaunchArg('db', default_value=False),
        DeclareBooleanLaunchArg('debug', default_value=False),
        DeclareBooleanLaunchArg('use_rviz', default_value=True)])
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


_MANAGER, _UNLOAD = 'controller_manager_name', 'unload_on_kill'


def generate_controllers_spawner_launch_description(
    controller_names: Iterable[Any], controller_params_files: Iterable[Any] | None = None,
    extra_spawner_args: Iterable[Any] = ()
) -> LaunchDescription:
    """Return the spawner of some controllers, with launch arguments for manager and end."""
    files = [word for file in controller_params_files or () if file
             for word in ('--param-file', file)]
    # The shell drops the last word where it is empty.
    unload = PythonExpression(
        ['"--unload-on-kill" if "true" == "', LaunchConfiguration(_UNLOAD), '" else ""'])
    return LaunchDescription([
        DeclareLaunchArgument(_MANAGER, default_value='controller_manager',
                              description='Name of the controller manager'),
        DeclareLaunchArgument(_UNLOAD, default_value='false',
                              description='Whether the controllers are unloaded at the end'),
        _spawner([*controller_names, '--controller-manager', LaunchConfiguration(_MANAGER),
                  *files, unload, *extra_spawner_args]),
    ])


def generate_controllers_spawner_launch_description_from_dict(
    controller_info_dict: Mapping[str, Any], extra_spawner_args: Iterable[Any] = ()
) -> LaunchDescription:
    """
    Return the spawner of some controllers.

    :param controller_info_dict: controller -> its parameter file, a list of them, or None.
    :raises ValueError: any other kind of value.
    """
    _check('controller_info_dict', controller_info_dict, dict)
    files = []
    for given in controller_info_dict.values():
        files += _files(given)
    return generate_controllers_spawner_launch_description(
        list(controller_info_dict), files, extra_spawner_args)


def generate_load_controller_launch_description(
    controller_name: Any, controller_params_file: Any = None,
    extra_spawner_args: Iterable[Any] = ()
) -> LaunchDescription:
    """Return the spawner of a controller."""
    return generate_controllers_spawner_launch_description(
        [controller_name], [controller_params_file], extra_spawner_args)


def generate_spawner_launch_description(
    controller_info_dict: Mapping[str, Mapping[str, Any]], extra_spawner_args: Iterable[Any] = ()
) -> LaunchDescription:
    """
    Return a spawner whose controllers have options of their own.

    :param controller_info_dict: controller -> its ``param_file``, ``load_only``, ``inactive`` and
        ``ros_args``.
    :raises ValueError: a value of another kind.
    """
    _check('controller_info_dict', controller_info_dict, dict)
    words: list[Any] = []
    for name, info in controller_info_dict.items():
        words += ['--controller', name]
        words += [word for file in _files(info.get('param_file'))
                  for word in ('--param-file', file)]
        for key in ('load_only', 'inactive'):
            if _check(key, info.get(key, False), bool):
                words.append(f"--{key.replace('_', '-')}")
        if 'ros_args' in info:
            words += ['--controller-ros-args', _check('ros_args', info['ros_args'], str)]
    return LaunchDescription([_spawner([*words, *extra_spawner_args])])


def _spawner(arguments: Iterable[Any]) -> Node:
    return Node(package='controller_manager', executable='spawner', arguments=list(arguments),
                shell=True, output='screen')


def _files(given: Any) -> list[Any]:
    if not given:
        return []
    return list(given) if isinstance(given, list) else [_check('parameter file', given, str)]


def _check(name: str, value: Any, kind: type) -> Any:
    """Return a value; ValueError where it is not of its kind."""
    if type(value) is not kind:
        raise ValueError(f'{name}: {value!r} is a {type(value).__name__}, not a {kind.__name__}')
    return value
