# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A process of a launch file, and the upstream program that it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
import os
import shlex
import shutil
from typing import Any, TypeAlias

from armsim_ros.launch.lookup import current_lookup

#: Parameters as a block of names, or a file of them.
ParameterSource: TypeAlias = 'Mapping[str, Any] | str'
#: Key of a parameter file for all nodes.
ALL_NODES = '/**'


@dataclass
class RosNode:
    """
    What makes a process a node.

    :param name: '' where the program names itself.
    :param namespace: absolute.
    :param parameters: in order, later ones win.
    :param group_parameters: those of the groups around it, before its own.
    :param key: of its own parameters in a file; its full name where that is given.
    :param remappings: (from, to).
    """

    package: str
    executable: str
    name: str = ''
    namespace: str = '/'
    parameters: Sequence[ParameterSource] = ()
    group_parameters: Sequence[ParameterSource] = ()
    key: str = ALL_NODES
    remappings: Sequence[tuple[str, str]] = ()
    arguments: Sequence[str] = ()
    ros_arguments: Sequence[str] = ()

    def merged(self) -> dict[str, Any]:
        """Return the parameters that are not in files."""
        return {name: value for source in (*self.group_parameters, *self.parameters)
                if not isinstance(source, str) for name, value in source.items()}

    @property
    def parameter_files(self) -> list[str]:
        """The words that name the files with parameters."""
        return [word for source in (*self.group_parameters, *self.parameters)
                if isinstance(source, str) for word in ('--params-file', source)]


@dataclass
class ProcessSpec:
    """
    A process to start.

    :param command: without what makes it a node.
    :param node: of a node, else None.
    """

    command: list[str]
    environment: dict[str, str]
    name: str
    cwd: str | None = None
    shell: bool = False
    output: str = 'screen'
    emulate_tty: bool = False
    respawn: bool = False
    respawn_delay: float = 0.0
    respawn_max_retries: int = -1
    sigterm_timeout: float = 5.0
    sigkill_timeout: float = 5.0
    prefix: list[str] = field(default_factory=list)
    node: RosNode | None = None

    @property
    def label(self) -> str:
        """``PKG/EXE``, or ``-/PROGRAM`` of a process that is not a node."""
        if self.node is not None:
            return f'{self.node.package}/{self.node.executable}'
        return f'-/{program_of(self.command, self.shell)}'

    @property
    def arguments(self) -> list[str]:
        """The arguments of its program, of ``ros2 run PACKAGE PROGRAM ...`` too."""
        words = list(self.node.arguments if self.node is not None else self.command)
        if self.shell:  # it splits words at blanks, and drops empty ones
            words = shlex.split(' '.join(words))
        return words if self.node is not None else words[4:]

    def dry_line(self) -> str:
        """Return the line of ``--dry-run``."""
        node = self.node
        program = self.label.partition('/')[2]
        name = (node.name if node is not None and node.name else self.name) or program
        names = [_word(str(parameter)).replace(',', '_')
                 for parameter in parameter_names(node)] if node else []
        return (f'process: {_word(self.label)} name={_word(name)} '
                f'ns={node.namespace if node else "/"} parameters={",".join(names)}')


def parameter_names(node: RosNode) -> list[str]:
    """Return the names of a node's parameters, each once."""
    found: dict[str, None] = {}
    for source in (*node.group_parameters, *node.parameters):
        if isinstance(source, str):
            found[os.path.basename(source)] = None
        else:
            found.update(dict.fromkeys(name.partition('.')[0] for name in source))
    return list(found)


def program_of(command: Sequence[str], shell: bool) -> str:
    """Return the name of a command's program."""
    words = ' '.join(command).split() if shell else list(command)
    return os.path.basename(words[0]) if words else ''


def _word(text: str) -> str:
    return '_'.join(text.split())


class ProgramRole(Enum):
    """The role of an upstream program."""

    SIMULATION = 'the simulation with its controller manager'
    WORLD = 'the world of the simulation'
    SPAWN_ROBOT = 'puts the robot into the simulation'
    BRIDGE = 'the simulation publishes these topics itself'
    SPAWNER = 'loads and activates controllers'
    UNSPAWNER = 'deactivates and unloads controllers'
    HARDWARE_SPAWNER = 'configures or activates hardware components'
    MOVE_GROUP = 'planning and execution'
    SERVO = 'commands of joints, twists and poses to joint commands'
    DESCRIPTION = 'publishes the robot description and transforms'
    JOINT_STATES = 'publishes joint states'
    STATIC_TRANSFORM = 'publishes the fixed transform of its arguments'
    STATIC_BROADCASTER = 'publishes the fixed transform of its parameters'
    TF_ECHO = 'prints the transform between two frames'
    TF_MONITOR = 'prints the delays of transforms'
    VIEW_FRAMES = 'draws the tree of frames'
    ROSBRIDGE = 'rosbridge, for clients without ROS'
    FOXGLOVE = 'Foxglove'
    ROSAPI = 'the bridge serves rosapi, too'
    VENDOR = "the arm's driver; its endpoints are the simulation's"


#: (package, executable) -> what it does.
NODES: dict[tuple[str, str], ProgramRole] = {
    ('controller_manager', 'ros2_control_node'): ProgramRole.SIMULATION,
    ('controller_manager', 'spawner'): ProgramRole.SPAWNER,
    ('controller_manager', 'spawner.py'): ProgramRole.SPAWNER,
    ('controller_manager', 'unspawner'): ProgramRole.UNSPAWNER,
    ('controller_manager', 'unspawner.py'): ProgramRole.UNSPAWNER,
    ('controller_manager', 'hardware_spawner'): ProgramRole.HARDWARE_SPAWNER,
    ('moveit_ros_move_group', 'move_group'): ProgramRole.MOVE_GROUP,
    ('moveit_servo', 'servo_node'): ProgramRole.SERVO,
    ('moveit_servo', 'servo_node_main'): ProgramRole.SERVO,
    ('robot_state_publisher', 'robot_state_publisher'): ProgramRole.DESCRIPTION,
    ('joint_state_publisher', 'joint_state_publisher'): ProgramRole.JOINT_STATES,
    ('joint_state_publisher_gui', 'joint_state_publisher_gui'): ProgramRole.JOINT_STATES,
    ('tf2_ros', 'static_transform_publisher'): ProgramRole.STATIC_TRANSFORM,
    ('tf2_ros', 'static_transform_broadcaster_node'): ProgramRole.STATIC_BROADCASTER,
    ('tf2_ros', 'tf2_echo'): ProgramRole.TF_ECHO,
    ('tf2_ros', 'tf2_monitor'): ProgramRole.TF_MONITOR,
    ('tf2_tools', 'view_frames'): ProgramRole.VIEW_FRAMES,
    ('rosbridge_server', 'rosbridge_websocket'): ProgramRole.ROSBRIDGE,
    ('rosbridge_server', 'rosbridge_websocket.py'): ProgramRole.ROSBRIDGE,
    ('foxglove_bridge', 'foxglove_bridge'): ProgramRole.FOXGLOVE,
    ('rosapi', 'rosapi_node'): ProgramRole.ROSAPI,
    ('ros_gz_sim', 'create'): ProgramRole.SPAWN_ROBOT,
    ('ros_ign_gazebo', 'create'): ProgramRole.SPAWN_ROBOT,
    ('ros_gz_sim', 'gzserver'): ProgramRole.WORLD,
    ('gazebo_ros', 'spawn_entity.py'): ProgramRole.SPAWN_ROBOT,
    ('gazebo_ros', 'gzserver'): ProgramRole.WORLD,
    ('gazebo_ros', 'gzclient'): ProgramRole.BRIDGE,
    ('ros_gz_bridge', 'parameter_bridge'): ProgramRole.BRIDGE,
    ('ros_gz_bridge', 'bridge_node'): ProgramRole.BRIDGE,
    ('ros_ign_bridge', 'parameter_bridge'): ProgramRole.BRIDGE,
}
#: Replaced only where they are not installed: they are no part of the robot.
_TOOLS = (ProgramRole.TF_ECHO, ProgramRole.TF_MONITOR, ProgramRole.VIEW_FRAMES)
#: Programs of drivers beside ros2_control; the simulation has their endpoints.
NODES.update({('ur_robot_driver', name): ProgramRole.VENDOR for name in (
    'dashboard_client', 'robot_state_helper', 'controller_stopper_node', 'urscript_interface',
    'trajectory_until_node')})
#: The program of a hand's driver, whose node is named as in the launch file.
HAND = 'franka_gripper_node'
NODES['franka_gripper', HAND] = ProgramRole.VENDOR
#: Holds the arm until its program is played, unless headless_mode plays it.
CONTROLLER_STOPPER = 'controller_stopper_node'
#: Class of a component -> the program that does its work in a process of its own.
COMPONENTS: dict[str, tuple[str, str]] = {
    'moveit_servo::ServoNode': ('moveit_servo', 'servo_node'),
    'robot_state_publisher::RobotStatePublisher': (
        'robot_state_publisher', 'robot_state_publisher'),
    'tf2_ros::StaticTransformBroadcasterNode': ('tf2_ros', 'static_transform_broadcaster_node'),
}
#: First words of commands that are not nodes.
COMMANDS: dict[tuple[str, ...], ProgramRole] = {
    ('gz', 'sim'): ProgramRole.WORLD,
    ('ign', 'gazebo'): ProgramRole.WORLD,
    ('ruby', '$(which', 'gz)', 'sim'): ProgramRole.WORLD,
    ('gzserver',): ProgramRole.WORLD,
    ('gazebo',): ProgramRole.WORLD,
    ('gzclient',): ProgramRole.BRIDGE,
}


def role_of(spec: ProcessSpec) -> ProgramRole | None:
    """Return the role of a process that is replaced here, None for any other."""
    node = spec.node
    if node is not None:
        if node.executable.endswith('ros2_control_node'):
            return ProgramRole.SIMULATION
        return _role_of_program(node.package, node.executable)
    words = ' '.join(spec.command).split() if spec.shell else spec.command
    for first, role in COMMANDS.items():
        if [program_of(words[:1], False), *words[1:len(first)]] == list(first):
            return role
    if words[:2] == ['ros2', 'run'] and len(words) > 3:
        return _role_of_program(words[2], words[3])
    return None


def _role_of_program(package: str, executable: str) -> ProgramRole | None:
    role = NODES.get((package, executable))
    if role in _TOOLS and current_lookup().program(package, executable) is not None:
        return None
    return role


def is_known(spec: ProcessSpec) -> bool:
    """Return whether a process would be started, or is replaced."""
    if role_of(spec) is not None:
        return True
    if spec.node is not None:
        lookup, names = current_lookup(), (spec.node.package, spec.node.executable)
        return lookup.program(*names) is not None or bool(lookup.console_script(*names))
    program = spec.command[0]
    if spec.shell:
        return True
    return shutil.which(program, path=spec.environment.get('PATH')) is not None


_TEXTS = {'file': 'file', 'string': 'text', 'name': 'name', 'entity': 'name', 'topic': 'topic',
          'param': 'topic', 'world': 'world'}
_NUMBERS = ('x', 'y', 'z', 'R', 'P', 'Y')
_FLAGS = ('allow_renaming', 'unpause', 'stdin', 'database')


@dataclass
class SpawnArguments:
    """What is spawned, and where [m, rad]."""

    name: str = ''
    file: str = ''
    text: str = ''
    topic: str = ''
    world: str = ''
    pose: dict[str, float] = field(default_factory=dict)

    @property
    def by_topic(self) -> bool:
        """Whether the description comes from a topic or parameter."""
        return bool(self.topic) or not (self.file or self.text)

    def placement(self) -> dict[str, list[float]]:
        """Return the pose as the simulation's settings write it."""
        if not any(self.pose.values()):
            return {}
        return {'xyz': [self.pose.get(axis, 0.0) for axis in 'xyz'],
                'rpy': [self.pose.get(axis, 0.0) for axis in 'RPY']}


def read_spawn_arguments(words: Sequence[str]) -> SpawnArguments:
    """Parse the command line; unknown words are skipped, as upstream."""
    found = SpawnArguments()
    rest = iter(words)
    for word in rest:
        name, sign, value = word.lstrip('-').partition('=')
        if not word.startswith('-') or name in _FLAGS:
            continue
        if name in _TEXTS:
            text = value if sign else next(rest, '')
            if text:
                setattr(found, _TEXTS[name], text)
        elif name in _NUMBERS:
            try:
                found.pose[name] = float(value if sign else next(rest, '0'))
            except ValueError:
                found.pose[name] = 0.0
    return found
