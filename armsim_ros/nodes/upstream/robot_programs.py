# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""ros2_control_node, move_group and servo_node by the command lines of upstream's."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
import sys
from tempfile import TemporaryDirectory
from typing import Any

import yaml

from armsim_ros.cli.arguments import split_ros_args
from armsim_ros.cli.node_arguments import NodeArguments, read_node_arguments
from armsim_ros.config.controllers.controller_manager import (
    ControllerEntry,
    ControllerManagerParameters,
)
from armsim_ros.config.sections import UNUSED_MANAGER_KEYS
from armsim_ros.errors import ArmsimError, USAGE_STATUS
from armsim_ros.launch.process_spec import ALL_NODES, HAND
from armsim_ros.nodes import robot_program
from armsim_ros.nodes.upstream.robot_package import (
    described_package,
    PREFIX,
    RobotPackage,
    SEMANTIC,
    URDF,
    wait_for_descriptions,
)

_BLOCK = 'moveit_servo.'
#: Parameters of move_group about its octomap, beside a block for each sensor.
_OF_OCTOMAP = ('sensors', 'octomap_resolution', 'octomap_frame')
#: How the name of a pipeline's parameter ends that adds capabilities.
_OF_PIPELINE = '.capabilities'
#: Parameters beside the block.
_BESIDE = ('butterworth_filter_coeff', 'update_period', 'planning_group_name')
#: Upstream's defaults of what is the robot's own where servo is started with a robot of ours.
_DEFAULTS = {
    f'{_BLOCK}command_out_topic': '/panda_arm_controller/joint_trajectory',
    f'{_BLOCK}joint_topic': '/joint_states',
    f'{_BLOCK}monitored_planning_scene_topic': '/planning_scene',
}


def move_group(argv: Sequence[str] | None = None) -> int:
    """
    Run move_group for the robot that parameters or topics describe.

    :returns: the exit status of move_group.
    """
    return _run('move_group', robot_program.move_group, move_group_words, argv)


def servo_node(argv: Sequence[str] | None = None) -> int:
    """
    Run servo_node for the robot that parameters or topics describe.

    :returns: the exit status of servo_node.
    """
    return _run('servo_node', robot_program.servo_node, servo_words, argv)


def _run(
    name: str, serve: Callable[[Sequence[str]], int],
    words_of: Callable[[NodeArguments, Path], list[str]], argv: Sequence[str] | None,
) -> int:
    with TemporaryDirectory(prefix=PREFIX) as folder:
        try:
            _, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
            words = words_of(read_node_arguments(ros_args, name), Path(folder))
        except ArmsimError as error:
            print(error, file=sys.stderr, flush=True)
            return USAGE_STATUS
        return serve(words)


def move_group_words(arguments: NodeArguments, folder: Path) -> list[str]:
    """
    Return the words that start move_group for a robot, whose files are written into a folder.

    :raises ConfigError: where a description is none.
    """
    values = arguments.values
    values.setdefault('moveit_manage_controllers', False)
    words = described_package(arguments, folder)
    arguments.rest += _params_file(folder / 'move_group.yaml', {
        **sensor_parameters(values),
        **{name: value for name, value in values.items() if name.endswith(_OF_PIPELINE)}})
    arguments.rest += [word for name in (URDF, SEMANTIC) if values.get(f'publish_{name}') is True
                       for word in ('-p', f'publish_{name}:=true')]
    return [*words, *arguments.ros_args(with_name=arguments.namespace != '/')]


def servo_words(arguments: NodeArguments, folder: Path) -> list[str]:
    """
    Return the words that start servo_node for a robot, whose files are written into a folder.

    :raises ConfigError: where a description is none.
    """
    words = described_package(arguments, folder)
    arguments.rest += _params_file(
        folder / 'servo_parameters.yaml', servo_parameters(arguments.values))
    return [*words, *arguments.ros_args(with_name=True)]


def _params_file(file: Path, parameters: Mapping[str, Any], key: str = ALL_NODES) -> list[str]:
    """Write parameters of some nodes into a file; return the words that name it."""
    if not parameters:
        return []
    content = {key: {'ros__parameters': dict(parameters)}}
    file.write_text(yaml.safe_dump(content), encoding='utf-8')
    return ['--params-file', str(file)]


def sensor_parameters(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters of an octomap's sensors of those that a launch file gives."""
    listed = values.get('sensors')
    names = [name for name in listed if name] if isinstance(listed, list) else []
    if not names:
        return {}
    return {name: value for name, value in values.items()
            if name in _OF_OCTOMAP or name.partition('.')[0] in names}


def servo_parameters(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return servo's own parameters of those that a launch file gives."""
    own = {name: value for name, value in values.items()
           if name.startswith(_BLOCK) or name in _BESIDE}
    return {**_DEFAULTS, **own}


_DESCRIPTION = 'robot_description'
#: Parameters that do not concern the controller manager.
_NOT_THE_MANAGERS = (_DESCRIPTION, 'use_sim_time', 'robot_description_semantic')
_OF_THE_MANAGER = {*ControllerManagerParameters.model_fields, *UNUSED_MANAGER_KEYS}
#: Prefix of the parameters for the pose and start state of the robot; ours alone.
PLACEMENT = 'armsim.'


def ros2_control_node(argv: Sequence[str] | None = None) -> int:
    """
    Run the simulation of the robot that a parameter or topic describes.

    :returns: the exit status of the simulation.
    """
    return _run('controller_manager', robot_program.simulation, _described_simulation, argv)


def _described_simulation(arguments: NodeArguments, folder: Path) -> list[str]:
    urdf = arguments.values.get(_DESCRIPTION)
    if not urdf:
        topics = (_DESCRIPTION, f'{arguments.name}/{_DESCRIPTION}')
        urdf = next(iter(wait_for_descriptions(arguments, topics).values()))
    return simulation_words(str(urdf), arguments, folder)


def simulation_words(urdf: str, arguments: NodeArguments, folder: Path) -> list[str]:
    """
    Return the words that start the simulation of a robot, whose files are written into a folder.

    :raises ConfigError: where the text is not a URDF.
    """
    package = RobotPackage(folder, urdf)
    values = arguments.values
    own = {name.removeprefix(PLACEMENT): value for name, value in values.items()
           if name.startswith(PLACEMENT)}
    texts = [file.read_text(encoding='utf-8') for file in arguments.files]
    hardware = {'program': own['program']} if own.get('program') else {}
    if own.get('gripper'):
        hand = read_node_arguments(own['gripper'], HAND)
        hardware['gripper'] = hand.name
        arguments.rest += _params_file(
            folder / 'hand_parameters.yaml', hand.values, f'/**/{hand.name}')
    package.add_simulation(
        spawn=_broadcasters(values) if own.get('joint_states') else (),
        placement={key: own[key] for key in ('xyz', 'rpy') if key in own},
        hardware=hardware)
    controllers = [package.add_controllers(number, text) for number, text in enumerate(texts)
                   if not _is_of_the_launch(text)]
    manager = {name: value for name, value in values.items()
               if name not in _NOT_THE_MANAGERS and not name.startswith(PLACEMENT)
               and (name.partition('.')[0] in _OF_THE_MANAGER
                    or name.rpartition('.')[2] in ControllerEntry.model_fields)}
    if manager:
        controllers.append(package.add_manager(manager, len(texts)))
    words = [f'robot:={package.folder}', f'urdf:={package.urdf}']
    if controllers:
        words.append(f"controllers:={','.join(map(str, controllers))}")
    if own.get('packages_path'):
        words.append(f"packages_path:={own['packages_path']}")
    if own.get('world'):
        words.append(f"world:={own['world']}")
    elif not own.get('floor'):
        words.append(f'world:={package.add_empty_world()}')
    if arguments.namespace != '/':
        words.append(f'namespace:={arguments.namespace}')
    return [*words, *arguments.ros_args()]


def _broadcasters(values: Mapping[str, object]) -> list[str]:
    """Return the joint state broadcasters among the manager's parameters."""
    return [name.removesuffix('.type') for name, value in values.items()
            if name.endswith('.type') and str(value).endswith('/JointStateBroadcaster')]


def _is_of_the_launch(text: str) -> bool:
    """Return whether a parameter file holds the description or ours, and no controllers."""
    return (f'{_DESCRIPTION}:' in text and '<robot' in text) or f'{PLACEMENT}packages_path' in text
