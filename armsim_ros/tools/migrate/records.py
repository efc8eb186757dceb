# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a file contributes, block by block, in its order."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from armsim_ros.config.draft import ConfigDraft
from armsim_ros.config.layout import LayoutReader
from armsim_ros.config.yaml.node import ROS2_KEY, YamlNode
from armsim_ros.config.yaml.source import read_yaml_file
from armsim_ros.errors import Location
from armsim_ros.tools.migrate.source_text import SourceText


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
