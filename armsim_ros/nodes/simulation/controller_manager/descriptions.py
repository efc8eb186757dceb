# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where the settings of a controller that is to be loaded come from."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rclpy.node import Node

from armsim_ros.config.controllers.controller_settings import ControllerSettings, read_controller
from armsim_ros.config.draft import ConfigDraft, empty_node
from armsim_ros.config.layout import LayoutReader
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.config.yaml.node import node_of
from armsim_ros.config.yaml.source import read_yaml_file
from armsim_ros.errors import ConfigError, ControllerError, Location, nearest, Severity


class ControllerDescriptions:
    """
    Finds a controller by the manager's parameters, else among the robot's files.

    The parameters are ``<name>.type`` and ``<name>.params_file``, which the spawner sets.

    :param node: the manager's node; it allows parameters that nobody declared.
    :param settings: the robot's files.
    """

    def __init__(self, node: Node, settings: RobotSettings) -> None:
        self._node = node
        self._settings = settings

    def find(self, name: str) -> ControllerSettings:
        """
        Return a controller's settings.

        :raises ControllerError: nothing describes it.
        :raises ConfigError: its parameter files have mistakes.
        """
        files = self._texts(f'{name}.params_file')
        kind = ''.join(self._texts(f'{name}.type')[:1])
        known = self._settings.controller(name)
        if known is not None and not files and kind in ('', known.type, known.source_type):
            return known
        if not kind and not files:
            names = tuple(one.name for one in self._settings.controllers)
            hint = nearest(name, names) or f'known: {", ".join(names) or "none"}'
            raise ControllerError(
                f"nothing describes a controller '{name}': no file of the robot, and the "
                f"parameter '{name}.type' is not set; {hint}"
            )
        return read_description(name, kind, files)

    def _texts(self, parameter: str) -> tuple[str, ...]:
        if not self._node.has_parameter(parameter):
            return ()
        value = self._node.get_parameter(parameter).value
        texts = (value,) if isinstance(value, str) else tuple(value or ())
        return tuple(text for text in texts if text)


def read_description(name: str, kind: str, files: Sequence[str]) -> ControllerSettings:
    """
    Read one controller from parameter files, in the layout of ROS 1 or ROS 2.

    :param kind: its type; '' where the files give it.
    :param files: later files win.
    :raises ConfigError: every mistake.
    """
    draft = ConfigDraft()
    reader = LayoutReader(draft)
    for file in files:
        reader.read(read_yaml_file(Path(file)), Path(file).stem)
    block = draft.section('controllers').get(name) or empty_node(Location(f"controller '{name}'"))
    if kind:
        block = block.with_value({**block.entries, 'type': node_of(kind, block.where)})
    settings = read_controller(name, block, draft.problems)
    mistakes = [one for one in draft.problems if one.severity is Severity.ERROR]
    if mistakes or settings is None:
        raise ConfigError(mistakes)
    return settings
