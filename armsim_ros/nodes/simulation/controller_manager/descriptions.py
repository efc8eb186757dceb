# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where the settings of a controller that is to be loaded come from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rclpy.node import Node

from armsim_ros.config.controllers.controller_settings import ControllerSettings, read_controller
from armsim_ros.config.draft import ConfigDraft, empty_node
from armsim_ros.config.layout import LayoutReader
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.config.yaml.node import merge_nodes, node_of, split_keys, YamlNode
from armsim_ros.config.yaml.node_parameters import is_ros2_file, parameters_of_node
from armsim_ros.config.yaml.source import read_yaml_file
from armsim_ros.errors import ConfigError, ControllerError, Location, nearest, Severity
from armsim_ros.nodes.upstream.node_parameters import read_node_arguments


class ControllerDescriptions:
    """
    Finds a controller among the robot's files and by the manager's parameters, which win.

    The parameters are those of a controller in ``controller_manager``, which the spawner sets:
    ``<name>.type``, ``<name>.params_file``, ``<name>.node_options_args`` and
    ``<name>.fallback_controllers``.

    :param node: the manager's node; it allows parameters that nothing has declared.
    :param settings: the robot's files.
    """

    def __init__(self, node: Node, settings: RobotSettings) -> None:
        self._node = node
        self._settings = settings

    def find(self, name: str) -> ControllerSettings:
        """
        Return a controller's settings.

        :raises ControllerError: nothing describes it.
        :raises ConfigError: its parameter files have errors.
        """
        options = read_node_arguments(self.node_options(name), name)
        files = [*self._texts(name, 'params_file'), *map(str, options.files)]
        kind = ''.join(self._texts(name, 'type')[:1])
        known = self._settings.controller(name)
        block = read_parameters(name, self._node.get_namespace(), files)
        if known is not None and kind in ('', known.type, known.source_type):
            if not files and not options.values:
                return known
            own = node_of(known.parameters.model_dump(exclude_unset=True, by_alias=True),
                          Location(f"controller '{name}'"))
            block, kind = merge_nodes(own, block)[0], known.type
        elif not kind and not files:
            names = tuple(controller.name for controller in self._settings.controllers)
            hint = nearest(name, names) or f'known: {", ".join(names) or "none"}'
            raise ControllerError(
                f"nothing describes a controller '{name}': no file of the robot, and the "
                f"parameter '{name}.type' is not set; {hint}"
            )
        return read_description(name, kind, block, options.values)

    def fallback_controllers(self, name: str) -> tuple[str, ...]:
        """Return the fallback controllers of a controller."""
        return self._texts(name, 'fallback_controllers')

    def node_options(self, name: str) -> tuple[str, ...]:
        """Return the ROS arguments of a controller's node."""
        words = tuple(word for word in self._texts(name, 'node_options_args')
                      if word not in ('--ros-args', '--'))
        return ('--ros-args', *words) if words else ()

    def _texts(self, name: str, key: str) -> tuple[str, ...]:
        """Return a parameter of a controller's block, from the robot's files if it is not set."""
        parameter = f'{name}.{key}'
        if self._node.has_parameter(parameter):
            value = self._node.get_parameter(parameter).value
        else:
            entry = self._settings.controller_manager.controllers.get(name)
            value = getattr(entry, key, None) if key != 'type' else None
        texts = (value,) if isinstance(value, str) else tuple(value or ())
        return tuple(text for text in texts if text)


def read_parameters(name: str, namespace: str, files: Sequence[str]) -> YamlNode:
    """
    Read a controller's parameters from files, in the layout of ROS 1 or ROS 2; later files win.

    :param namespace: of the controller's node.
    :raises ConfigError: a file cannot be read.
    """
    block = empty_node(Location(f"controller '{name}'"))
    for file in files:
        root = read_yaml_file(Path(file))
        if is_ros2_file(root):
            found = parameters_of_node(root, name, namespace)
        else:
            draft = ConfigDraft()
            LayoutReader(draft).read(root, Path(file).stem)
            found = draft.section('controllers').get(name)
        if found is not None:
            block = merge_nodes(block, found)[0]
    return block


def read_description(
    name: str, kind: str, block: YamlNode, values: Mapping[str, Any]
) -> ControllerSettings:
    """
    Return the settings of a controller.

    :param kind: its type; '' where the block gives it.
    :param block: its parameters.
    :param values: parameters that win over those, by their names with dots.
    :raises ConfigError: every error.
    """
    where = Location(f"controller '{name}'")
    block = merge_nodes(block, split_keys(node_of(values, where), '.'))[0]
    if kind:
        block = block.with_value({**block.entries, 'type': node_of(kind, block.where)})
    draft = ConfigDraft()
    settings = read_controller(name, block, draft.problems, published=True)
    errors = [problem for problem in draft.problems if problem.severity is Severity.ERROR]
    if errors or settings is None:
        raise ConfigError(errors or draft.problems)  # an unknown type is only a warning
    return settings
