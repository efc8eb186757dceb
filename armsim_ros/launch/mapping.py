# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Decides what a process becomes: a program of ours, a foreign program, or a part of ours."""

from __future__ import annotations

from collections.abc import Callable, Sequence
import contextlib
from dataclasses import dataclass
from enum import Enum
import os
from pathlib import Path
import re
import shlex
import sys
from typing import Any

import yaml

from armsim_ros.cli.environment import program_command
from armsim_ros.launch.api.process import ExecuteLocal
from armsim_ros.launch.gz_bridge import unserved_topics
from armsim_ros.launch.lookup import current_lookup, script_text
from armsim_ros.launch.process_spec import (
    ALL_NODES,
    CONTROLLER_STOPPER,
    HAND,
    is_known,
    ProcessSpec,
    ProgramRole,
    read_spawn_arguments,
    role_of,
    RosNode,
    SpawnArguments,
)
from armsim_ros.launch.spawned_model import has_movable_joint, is_controlled, is_urdf
from armsim_ros.packages import package_of, workspace_of

_DUMPER = getattr(yaml, 'CSafeDumper', yaml.SafeDumper)
_DESCRIPTION = 'robot_description'
#: Parameter of ours: the simulation's own broadcaster publishes, which no spawner starts.
JOINT_STATES = 'armsim.joint_states'
#: Parameter of ours: the robot is in the world of a simulator, which has a floor.
FLOOR = 'armsim.floor'
#: Parameter of ours: the driver's program does not run before it is played.
PROGRAM = 'armsim.program'
#: Parameter of ours: the ROS arguments of the node of the vendor's hand.
GRIPPER = 'armsim.gripper'
#: Packages and files that a robot description names.
_PACKAGE = re.compile(r'(?:(?:package|model)://|\$\(find(?:-pkg-share)?\s+)([^/"\'\s)]+)')
_FILE = re.compile(r'file://+(/[^"\'<>\n]+?)/[^/"\']*["\']')
#: Where Gazebo looks for models.
_MODEL_PATHS = ('GZ_SIM_RESOURCE_PATH', 'IGN_GAZEBO_RESOURCE_PATH', 'GAZEBO_MODEL_PATH')
_PROGRAMS = {
    ProgramRole.SIMULATION: 'ros2_control_node', ProgramRole.MOVE_GROUP: 'move_group',
    ProgramRole.SERVO: 'servo_node',
    ProgramRole.SPAWNER: 'spawner', ProgramRole.UNSPAWNER: 'unspawner',
    ProgramRole.HARDWARE_SPAWNER: 'hardware_spawner',
    ProgramRole.DESCRIPTION: 'robot_state_publisher',
    ProgramRole.JOINT_STATES: 'joint_state_publisher',
    ProgramRole.STATIC_TRANSFORM: 'static_transform_publisher',
    ProgramRole.STATIC_BROADCASTER: 'static_transform_broadcaster_node',
    ProgramRole.TF_ECHO: 'tf2_echo', ProgramRole.TF_MONITOR: 'tf2_monitor',
    ProgramRole.VIEW_FRAMES: 'view_frames',
    ProgramRole.ROSBRIDGE: 'rosbridge_websocket', ProgramRole.FOXGLOVE: 'foxglove_bridge',
}
#: Programs whose work the simulation does; they get no process of their own.
_PARTS = (ProgramRole.WORLD, ProgramRole.BRIDGE, ProgramRole.VENDOR)


class Kind(Enum):
    """What becomes of a process."""

    RUN = 'a process is started'
    PART = 'it is there while the simulation runs'
    DONE = 'it has ended at once'
    UNKNOWN = 'it is not installed'
    REFUSED = 'the launch cannot go on without it'


@dataclass
class Start:
    """
    A process of a batch and what becomes of it.

    :param command: of a process that is started.
    :param note: for the log, at its level.
    :param is_simulation: whether it is the simulation.
    :param is_ours: whether it is a program of this package.
    """

    action: ExecuteLocal
    spec: ProcessSpec
    kind: Kind
    command: Sequence[str] = ()
    note: str = ''
    level: str = 'INFO'
    is_simulation: bool = False
    is_ours: bool = False
    simulation: Start | None = None


class Mapping:
    """
    Decides for a launch, batch by batch.

    :param keep_text: writes a text into a file and returns its path.
    """

    def __init__(self, keep_text: Callable[[str, str], str]) -> None:
        self._keep_text = keep_text
        self._descriptions: dict[str, str] = {}
        self._simulated: set[str] = set()
        self._knows_controlled = False
        self._tells_joints = False
        self._plays_later = False
        self._gripper: RosNode | None = None

    def decide(self, batch: Sequence[tuple[ExecuteLocal, ProcessSpec]]) -> list[Start]:
        """Return what becomes of the processes of a batch, in order."""
        roles = [role_of(spec) for _, spec in batch]
        for (_, spec), role in zip(batch, roles, strict=True):
            if role is ProgramRole.DESCRIPTION and spec.node is not None:
                text = spec.node.merged().get(_DESCRIPTION)
                if text:
                    self._descriptions[_topic(spec.node, _DESCRIPTION)] = str(text)
        self._knows_controlled |= any(
            is_controlled(self._spawned_text(spec)) if role is ProgramRole.SPAWN_ROBOT
            else spec.node is not None
            and is_controlled(str(spec.node.merged().get(_DESCRIPTION) or ''))
            for (_, spec), role in zip(batch, roles, strict=True))
        self._tells_joints = ProgramRole.JOINT_STATES in roles and not any(
            role is ProgramRole.SPAWNER and 'joint_state' in ' '.join(spec.arguments)
            for (_, spec), role in zip(batch, roles, strict=True))
        self._plays_later = any(
            spec.node is not None and spec.node.executable == CONTROLLER_STOPPER
            and str(spec.node.merged().get('headless_mode')).lower() != 'true'
            for _, spec in batch)
        self._gripper = next((
            spec.node for _, spec in batch
            if spec.node is not None and spec.node.executable == HAND), None)
        return [self._decide(action, spec, role)
                for (action, spec), role in zip(batch, roles, strict=True)]

    def simulation_ended(self) -> None:
        """Note that another simulation may be started."""
        self._simulated.clear()

    def _decide(self, action: ExecuteLocal, spec: ProcessSpec, role: ProgramRole | None) -> Start:
        if role is None:
            return self._other(action, spec)
        if role is ProgramRole.SPAWN_ROBOT:
            return self._spawn(action, spec)
        if role is ProgramRole.SIMULATION and self._place(spec.node) in self._simulated:
            return Start(action, spec, Kind.PART, note='the same simulation serves both')
        if role in _PARTS:
            unserved = unserved_topics(spec)
            return Start(action, spec, Kind.PART, level='WARNING' if unserved else 'INFO',
                         note=unserved or f'{role.value}: part of the simulation')
        if role is ProgramRole.ROSAPI:
            return Start(action, spec, Kind.PART, note=role.value)
        return self._ours(action, spec, role)

    def _ours(self, action: ExecuteLocal, spec: ProcessSpec, role: ProgramRole) -> Start:
        node = spec.node or RosNode('-', _PROGRAMS[role])
        words = spec.arguments
        extra: dict[str, Any] = {}
        if role is ProgramRole.SIMULATION:
            self._simulated.add(self._place(node))
            text = str(node.merged().get(_DESCRIPTION) or self._description(node))
            extra = self._own_parameters(text)
            if text and _DESCRIPTION not in node.merged():
                extra[_DESCRIPTION] = text
            if self._tells_joints:
                extra[JOINT_STATES] = True
            if self._plays_later:
                extra[PROGRAM] = 'STOPPED'
            if self._gripper is not None:
                extra[GRIPPER] = self._ros_args(self._gripper, {})
        elif role in (ProgramRole.MOVE_GROUP, ProgramRole.SERVO):
            extra = self._own_parameters(str(node.merged().get(_DESCRIPTION) or ''))
        command = program_command('original', [
            _PROGRAMS[role], *words, *self._ros_args(node, extra)])
        return Start(action, spec, Kind.RUN, [*spec.prefix, *command],
                     is_simulation=role is ProgramRole.SIMULATION, is_ours=True)

    def _spawn(self, action: ExecuteLocal, spec: ProcessSpec) -> Start:
        """Give the first robot that is spawned to the simulation."""
        given = read_spawn_arguments(spec.arguments)
        text = self._spawned_text(spec)
        if is_controlled(text) and not is_urdf(text):
            text = self._description(spec.node or RosNode('-', 'create'))
            if '<ros2_control' not in text:
                return Start(action, spec, Kind.REFUSED, note=(
                    f"{given.file or given.name or 'the model'} is an SDF, which is not "
                    'simulated, and no robot_state_publisher has a URDF with <ros2_control> for '
                    "it; spawn the robot by its URDF ('-topic robot_description')"))
        reason = self._why_not_spawned(given, text)
        if reason:
            return Start(action, spec, Kind.DONE, level='WARNING', note=reason)
        self._simulated.add('/')
        parameters: dict[str, Any] = {**self._own_parameters(text), FLOOR: True, **{
            f'armsim.{key}': value for key, value in given.placement().items()}}
        if text:
            parameters[_DESCRIPTION] = text
        manager = RosNode('controller_manager', 'ros2_control_node')
        command = program_command('original', [
            'ros2_control_node', *self._ros_args(manager, parameters)])
        made = Start(action, spec, Kind.RUN, command, is_simulation=True, is_ours=True)
        return Start(action, spec, Kind.DONE, note='the robot is in the simulation',
                     simulation=made)

    def _spawned_text(self, spec: ProcessSpec) -> str:
        """Return the model that a process spawns, '' where the launch does not have it."""
        given = read_spawn_arguments(spec.arguments)
        node = spec.node or RosNode('-', 'create')
        return str(given.text or self._read(given.file, spec.environment)
                   or node.merged().get(_DESCRIPTION)
                   or (self._description(node, given.topic) if given.by_topic else ''))

    def _why_not_spawned(self, given: SpawnArguments, text: str) -> str:
        """
        Return why a model is not simulated, and what helps; '' for the robot.

        Upstream adds every model to the world, and only those with controllers are moved by them.
        """
        name = given.name or given.file or 'the model'
        if not text and not given.by_topic:
            return f"'{given.file or name}' is not found and not spawned"
        if not text and given.topic and self._descriptions:
            return (f"'{name}' is not spawned: no robot_state_publisher of this launch publishes "
                    f"'{given.topic}'")
        has_robot = self._knows_controlled or bool(self._simulated)
        if text and not is_controlled(text) and (
                has_robot or not is_urdf(text) or not has_movable_joint(text)):
            return (f"'{name}' has no <ros2_control>: an object, which is not simulated; put it "
                    'into the world with /spawn_entity (docs/world.md)')
        if self._simulated:
            return (f"'{name}' is not spawned: the simulation has its robot already; an object is "
                    'put into the world with /spawn_entity (docs/world.md), several robots are a '
                    'cell (docs/many_robots.md)')
        return ''

    def _other(self, action: ExecuteLocal, spec: ProcessSpec) -> Start:
        if not is_known(spec):
            return Start(action, spec, Kind.UNKNOWN)
        node = spec.node or _run_by_ros2(spec)
        if node is None:
            command = ['/bin/sh', '-c', ' '.join(spec.command)] if spec.shell else spec.command
            return Start(action, spec, Kind.RUN, [*spec.prefix, *command])
        command = [*spec.prefix, *self._program(node), *spec.arguments,
                   *self._ros_args(node, {})]
        if spec.shell:
            command = ['/bin/sh', '-c', shlex.join(command)]
        return Start(action, spec, Kind.RUN, command)

    def _program(self, node: RosNode) -> list[str]:
        """Return the words that start a program, installed or in its package's sources."""
        lookup = current_lookup()
        names = node.package, node.executable
        program, script = lookup.program(*names), lookup.console_script(*names)
        if program is None or (script and lookup.installed(*names) is None):
            # A module of the program's name may import others of its package relatively.
            text = script_text(script)
            return [sys.executable, self._keep_text(f'{node.executable}.py', text)]
        runs = os.access(program, os.X_OK) and program.suffix != '.py'
        return [str(program)] if runs else [sys.executable, str(program)]

    def _ros_args(self, node: RosNode, extra: dict[str, Any]) -> list[str]:
        """Return ``--ros-args`` with everything that the launch file gives a node."""
        words = ['--ros-args', *node.ros_arguments]
        if node.name:
            words += ['-r', f'__node:={node.name}']
        if node.namespace != '/':
            words += ['-r', f'__ns:={node.namespace}']
        shared = [(ALL_NODES, source) for source in node.group_parameters]
        own = [(node.key, source) for source in node.parameters]
        for key, source in (*shared, *own, (ALL_NODES, extra)):
            if isinstance(source, str):
                words += ['--params-file', source]
            elif source:
                content = {key: {'ros__parameters': dict(source)}}
                text = yaml.dump(content, Dumper=_DUMPER, sort_keys=False, allow_unicode=True)
                words += ['--params-file', self._keep_text('parameters.yaml', text)]
        for source_name, target in node.remappings:
            words += ['-r', f'{source_name}:={target}']
        return words

    def _own_parameters(self, text: str) -> dict[str, Any]:
        """
        Return what ours have to know of the launch: where the packages of a description are.

        :param text: the description; where it is not known yet, all places are named.
        """
        packages = current_lookup().packages
        if text:
            found = [packages.find(name) for name in dict.fromkeys(_PACKAGE.findall(text))]
            found += [package_of(Path(path)) for path in dict.fromkeys(_FILE.findall(text))]
        else:
            found = [folder for path in packages.near for folder in _around(path)]
        places = dict.fromkeys((*packages.path, *filter(None, found)))
        return {'armsim.packages_path': os.pathsep.join(map(str, places))} if places else {}

    def _description(self, node: RosNode, topic: str = '') -> str:
        """Return what a node reads from a topic; the robot's where that is published elsewhere."""
        own = self._descriptions.get(_topic(node, topic or _DESCRIPTION))
        if own or (topic and topic.rpartition('/')[2] != _DESCRIPTION):
            return own or ''
        known = self._descriptions.values()
        return next(filter(is_controlled, known), next(iter(known), ''))

    def _read(self, file: str, environment: dict[str, str]) -> str:
        """Return the text of a file, or of the model whose folder has this name."""
        if not file:
            return ''
        folders = [Path(folder) for name in _MODEL_PATHS
                   for folder in environment.get(name, '').split(os.pathsep) if folder]
        folders += [folder for package in current_lookup().packages.names().values()
                    for folder in (package, package / 'models')]
        for place in (Path(file), *(folder / file / 'model.sdf' for folder in folders)):
            with contextlib.suppress(OSError):
                return place.read_text(encoding='utf-8', errors='replace')
        return ''

    @staticmethod
    def _place(node: RosNode | None) -> str:
        return node.namespace if node is not None else '/'


def _topic(node: RosNode, name: str) -> str:
    """Return the absolute name of a node's topic, after its remappings."""
    rules = {source.lstrip('~/'): target for source, target in node.remappings}
    target = rules.get(name.lstrip('/'), name)
    return target if target.startswith('/') else f"{node.namespace.rstrip('/')}/{target}"


def _run_by_ros2(spec: ProcessSpec) -> RosNode | None:
    """Return what ``ros2 run PACKAGE PROGRAM ...`` runs of a package's sources, None otherwise."""
    words, lookup = spec.command, current_lookup()
    if spec.shell or words[:2] != ['ros2', 'run'] or len(words) < 4:
        return None
    package, name = words[2:4]
    if lookup.program(package, name) is None and not lookup.console_script(package, name):
        return None
    return RosNode(package, name)


def _around(path: Path) -> list[Path | None]:
    """Return the package of a file, and of those that it may name."""
    workspace, package = workspace_of(path), package_of(path)
    if workspace is not None:
        return [package, workspace / 'src', workspace / 'install']
    return [package, package.parent if package is not None else None]
