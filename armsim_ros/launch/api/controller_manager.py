# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The helpers of controller_manager for launch files that spawn controllers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from armsim_ros.launch.api.actions.configuration import DeclareLaunchArgument
from armsim_ros.launch.api.description import LaunchDescription
from armsim_ros.launch.api.ros_node import Node
from armsim_ros.launch.api.substitutions.programs import PythonExpression
from armsim_ros.launch.api.substitutions.texts import LaunchConfiguration

_MANAGER, _UNLOAD = 'controller_manager_name', 'unload_on_kill'


def generate_controllers_spawner_launch_description(
    controller_names: Iterable[Any], controller_params_files: Iterable[Any] | None = None,
    extra_spawner_args: Iterable[Any] = (),
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
    extra_spawner_args: Iterable[Any] = (),
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
    """
    Return a value.

    :raises ValueError: it is not of its kind.
    """
    if type(value) is not kind:
        raise ValueError(f'{name}: {value!r} is a {type(value).__name__}, not a {kind.__name__}')
    return value
