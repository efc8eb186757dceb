# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The content of all files in a neutral form, before anything is checked."""

from __future__ import annotations

from dataclasses import dataclass, field

from armsim_ros.config.yaml.node import merge_nodes, YamlNode
from armsim_ros.errors import ignored, Location, Problem

#: The blocks of the neutral form; each is a field of RobotSettings.
SECTIONS = (
    'controller_manager', 'controllers', 'spawn', 'joint_limits', 'kinematics', 'ompl',
    'moveit_controllers', 'trajectory_execution', 'planning_parameters', 'simulation', 'servo',
)


def empty_node(where: Location | None = None) -> YamlNode:
    """Return a mapping without entries."""
    return YamlNode({}, where or Location('the defaults'))


@dataclass
class ConfigDraft:
    """
    What was found so far.

    :param sections: block -> its entries, of all files together.
    :param namespaces: namespace -> where it was first seen.
    :param problems: errors and remarks found on the way.
    """

    sections: dict[str, YamlNode] = field(default_factory=dict)
    namespaces: dict[str, Location] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)

    def section(self, name: str) -> YamlNode:
        """Return a block; empty where no file has it."""
        return self.sections.get(name, empty_node())

    def add(self, section: str, node: YamlNode) -> None:
        """Lay entries over a block; a key that has another value already takes the new value."""
        known = self.sections.get(section)
        if known is None:
            self.sections[section] = node
            return
        self.sections[section], conflicts = merge_nodes(known, node)
        for path, first, second in conflicts:
            self.problems.append(ignored(Problem(
                f"{section}: '{path}' has another value here than in {first.place}",
                second.place, remedy='remove one of the two')))

    def add_entry(self, section: str, key: str, node: YamlNode) -> None:
        """Lay an entry over a block."""
        self.add(section, empty_node(node.place).with_value({key: node}))

    def override(self, section: str, path: list[str], node: YamlNode) -> None:
        """Override a value of the files."""
        for key in reversed(path):
            node = YamlNode({}, node.where).with_value({key: node})
        known = self.sections.get(section, empty_node(node.where))
        self.sections[section] = merge_nodes(known, node)[0]

    def see_namespace(self, namespace: str, where: Location) -> None:
        """Record the namespace of a controller."""
        self.namespaces.setdefault(namespace, where)
