# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The files of ROS 2, put together from the blocks of ROS 1's files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from armsim_ros.config.controllers.controller_settings import PARAMETERS, ROS1_TYPES
from armsim_ros.config.draft import ConfigDraft
from armsim_ros.config.kinematics import JointLimitsSettings, KinematicsSettings
from armsim_ros.config.layout import LayoutReader
from armsim_ros.config.servo import ServoNodeSettings
from armsim_ros.config.trajectory_execution import (
    MoveItControllerSettings,
    TrajectoryExecutionSettings,
)
from armsim_ros.config.yaml_node import ROS2_KEY, YamlNode
from armsim_ros.config.yaml_source import read_yaml_file
from armsim_ros.errors import Location
from armsim_ros.tools.migrate_text import real_number_edits, SourceText


@dataclass(frozen=True)
class Record:
    """
    A block, or an entry of a block.

    :param section: the block of the neutral form.
    :param key: the entry; '' for the whole block.
    """

    section: str
    key: str
    node: YamlNode
    namespace: str = ''


class FileRecords(ConfigDraft):
    """
    A draft of a file that remembers the order in which it was filled.

    :raises ConfigError: the file cannot be read.
    """

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.file = file
        self.root = read_yaml_file(file)
        self.records: list[Record] = []
        self._namespace = ''
        LayoutReader(self).read(self.root, file.stem)
        self.text = SourceText(file, self.root)

    @property
    def is_ros2(self) -> bool:
        """Whether it is in the layout of ROS 2."""
        return any(ROS2_KEY in inner.entries for inner in self.root.walk())

    @property
    def kinds(self) -> set[str]:
        """The blocks that it has something of."""
        return {record.section for record in self.records}

    def add(self, section: str, node: YamlNode) -> None:
        """Note a whole block."""
        self.records.append(Record(section, '', node))

    def add_entry(self, section: str, key: str, node: YamlNode) -> None:
        """Note an entry."""
        namespace = self._namespace if section == 'controllers' else ''
        self.records.append(Record(section, key, node, namespace))

    def see_namespace(self, namespace: str, where: Location) -> None:
        """Note the namespace of the controller that comes next."""
        self._namespace = namespace


CONTROLLERS, MOVEIT_CONTROLLERS = 'ros2_controllers.yaml', 'moveit_controllers.yaml'
MOVE_GROUP, SIMULATION = 'move_group.yaml', 'simulation_from_ros1.yaml'

#: Blocks whose files look the same in ROS 2 -> what they are checked as.
SAME_IN_BOTH: Mapping[str, Any] = {
    'joint_limits': JointLimitsSettings,
    'kinematics': dict[str, KinematicsSettings],
    'pipelines': None,
    'servo': ServoNodeSettings,
    'simulation': None,
    'spawn': None,
}
_FILE_OF = {'joint_limits': 'joint_limits.yaml', 'kinematics': 'kinematics.yaml',
            'pipelines': MOVE_GROUP, 'planning_parameters': MOVE_GROUP, 'simulation': SIMULATION}
_MANAGER = 'moveit_simple_controller_manager'


class Ros2Files:
    """
    Collects blocks and writes them as files.

    :param namespace: of the controllers, '' or such as ``/sunday``.
    """

    def __init__(self, namespace: str) -> None:
        self._namespace = namespace
        self._heads: dict[str, list[str]] = {}
        self._manager: list[str] = []
        self._types: list[tuple[str, str]] = []
        self._controllers: list[str] = []
        self._moveit: list[tuple[str, list[str]]] = []
        self._execution: list[str] = []
        self._others: dict[str, list[str]] = {}
        self.remarks: list[str] = []

    def take(self, file: FileRecords) -> None:
        """Take the content of a file."""
        targets = [self._take(file, record) for record in file.records]
        comments = file.text.other_comments()
        if comments and targets:
            self._heads.setdefault(targets[0], []).extend(comments)

    def files(self) -> dict[str, str]:
        """Return file name -> text."""
        found = {
            CONTROLLERS: self._controller_file(),
            MOVEIT_CONTROLLERS: self._moveit_file(),
            **{name: self._other_file(name) for name in self._others},
        }
        return {name: '\n'.join([*self._heads.get(name, []), *lines]) + '\n'
                for name, lines in found.items() if lines}

    def _take(self, file: FileRecords, record: Record) -> str:
        if record.section == 'controllers':
            return self._take_controller(file, record)
        if record.section == 'controller_manager':
            entries = {record.key: record.node} if record.key else record.node.entries
            self._manager += _dumped({key: entry.plain() for key, entry in entries.items()})
            self._say(file, record, CONTROLLERS, 'controller_manager')
            return CONTROLLERS
        if record.section == 'moveit_controllers':
            edits = real_number_edits(MoveItControllerSettings, record.node)
            lines = _indented(file.text.remarks_above(record.node), 4)
            lines += self._lines(file, record, 4, edits, ('name',))
            self._moveit.append((record.key, lines))
            self._say(file, record, MOVEIT_CONTROLLERS, f'{_MANAGER}.{record.key}')
            return MOVEIT_CONTROLLERS
        if record.section == 'trajectory_execution':
            return self._take_execution(file, record)
        return self._take_other(file, record)

    def _take_controller(self, file: FileRecords, record: Record) -> str:
        written = str(record.node.entries['type'].plain())
        ros1 = ROS1_TYPES.get(written)
        kind = ros1.type if ros1 else written
        self._types.append((record.key, kind))
        implied = {key: list(value) for key, value in (ros1.implied if ros1 else {}).items()
                   if key not in record.node.entries}
        edits = real_number_edits(PARAMETERS[kind], record.node)
        self._controllers += [
            *file.text.remarks_above(record.node),
            f'{self._namespace}/{record.key}:', f'  {ROS2_KEY}:',
            *(f'    {key}: {yaml.safe_dump(value, default_flow_style=True).strip()}'
              for key, value in implied.items()),
            *self._lines(file, record, 4, edits, ('type',))]
        changed = f"; type '{written}' is '{kind}'" if ros1 else ''
        self._say(file, record, CONTROLLERS, record.key, changed)
        if edits:
            self.remarks.append(f'  {len(edits)} whole numbers of {record.key} are doubles now')
        return CONTROLLERS

    def _take_execution(self, file: FileRecords, record: Record) -> str:
        if record.key:
            self._execution += _dumped({record.key: record.node.plain()})
        else:
            edits = real_number_edits(TrajectoryExecutionSettings, record.node)
            self._execution += [
                *file.text.remarks_above(record.node), 'trajectory_execution:',
                *self._lines(file, record, 2, edits)]
        self._say(file, record, MOVEIT_CONTROLLERS, record.key or record.section)
        return MOVEIT_CONTROLLERS

    def _take_other(self, file: FileRecords, record: Record) -> str:
        target = _FILE_OF.get(record.section, SIMULATION)
        lines = self._others.setdefault(target, [])
        indent = 4 if target == MOVE_GROUP else 2 if target == SIMULATION else 0
        if record.key and record.node.is_mapping:
            kind: Any = SAME_IN_BOTH.get(record.section)
            edits = real_number_edits(kind, record.node) if kind else {}
            remarks = file.text.remarks_above(record.node)
            head = f"{' ' * indent}{record.key}:"
            block = self._lines(file, record, indent + 2, edits)
            if head in lines:  # a pipeline of two files
                first = lines.index(head) + 1
                lines[first:first] = [*_indented(remarks, indent + 2), *block]
            else:
                lines += [*_indented(remarks, indent), head, *block]
        elif record.key:
            lines += _indented(_dumped({record.key: record.node.plain()}), indent)
        else:
            lines += self._lines(file, record, indent, {})
        self._say(file, record, target, record.key or record.section)
        return target

    def _lines(self, file: FileRecords, record: Record, column: int,
               edits: Mapping[tuple[int, int], str], dropped: tuple[str, ...] = ()) -> list[str]:
        """Return a block as its author wrote it; from its values where that cannot be."""
        lines = file.text.block(record.node, column, edits, dropped)
        if lines is not None:
            return lines
        values = {key: entry.plain() for key, entry in record.node.entries.items()
                  if key not in dropped}
        return _indented(_dumped(values), column) if values else []

    def _controller_file(self) -> list[str]:
        if not self._types and not self._manager:
            return []
        lines = [f'{self._namespace}/controller_manager:', f'  {ROS2_KEY}:',
                 *_indented(self._manager, 4)]
        for name, kind in self._types:
            lines += [f'    {name}:', f'      type: {kind}']
        return [*lines, *self._controllers]

    def _moveit_file(self) -> list[str]:
        if not self._moveit:
            return self._execution
        lines = [f'{_MANAGER}:', '  controller_names:',
                 *(f'    - {name}' for name, _ in self._moveit)]
        for name, block in self._moveit:
            lines += [f'  {name}:', *block]
        if not any(line.startswith('moveit_controller_manager:') for line in self._execution):
            plugin = TrajectoryExecutionSettings.model_fields['moveit_controller_manager'].default
            lines.insert(0, f'moveit_controller_manager: {plugin}')
        return [*lines, *self._execution]

    def _other_file(self, name: str) -> list[str]:
        head = {MOVE_GROUP: ['move_group:', f'  {ROS2_KEY}:'], SIMULATION: ['simulation:']}
        return [*head.get(name, []), *self._others[name]]

    def _say(self, file: FileRecords, record: Record, target: str, what: str,
             changed: str = '') -> None:
        place = record.node.place.line
        self.remarks.append(f'{file.text.name}:{place} -> {target}: {what}{changed}')


def _dumped(values: Mapping[str, object]) -> list[str]:
    return yaml.safe_dump(dict(values), sort_keys=False, allow_unicode=True).splitlines()


def _indented(lines: Iterable[str], column: int) -> list[str]:
    return [' ' * column + line for line in lines]
