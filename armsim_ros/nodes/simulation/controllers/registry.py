# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Controllers and their nodes, loaded and unloaded together."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rclpy.executors import Executor
from rclpy.node import Node

from armsim_ros.cli.node_arguments import read_node_arguments
from armsim_ros.config.controllers.controller_settings import ControllerSettings, read_controller
from armsim_ros.config.draft import ConfigDraft, empty_node
from armsim_ros.config.layout import LayoutReader
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.config.yaml_node import (
    is_ros2_file,
    merge_nodes,
    node_of,
    parameters_of_node,
    split_keys,
    YamlNode,
)
from armsim_ros.config.yaml_source import read_yaml_file
from armsim_ros.control.controller import Controller
from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.errors import ConfigError, ControllerError, Location, nearest, Severity
from armsim_ros.nodes.simulation.controllers.controller_nodes import (
    ControllerNode,
    create_controller_node,
)
from armsim_ros.nodes.simulation.dispatcher import Dispatcher
from armsim_ros.nodes.simulation.sim_time import SimTime


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
        self._node, self._settings = node, settings

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
                f"parameter '{name}.type' is not set; {hint}")
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


class ControllerRegistry(Mapping[str, ControllerNode]):
    """
    The node of each controller, in the order of loading.

    :param descriptions: find the settings of a controller that is to be loaded.
    :param namespace: where their nodes live.
    :param opened: gets each controller and its node once its own endpoints exist.
    """

    def __init__(
        self, manager: ControllerManager, descriptions: ControllerDescriptions, executor: Executor,
        dispatcher: Dispatcher, namespace: str, time: SimTime,
        opened: Callable[[Controller[Any], Node], object] = lambda *_: None
    ) -> None:
        self._opened, self._time, self._manager = opened, time, manager
        self._descriptions, self._executor, self._dispatcher = descriptions, executor, dispatcher
        self._namespace = namespace
        self._sides: dict[str, ControllerNode] = {}

    def load(self, name: str) -> None:
        """
        Load a controller and give it a node.

        :raises ControllerError: it is loaded already, or nothing describes it.
        :raises ConfigError: its parameters have errors.
        """
        if name in self._manager.controllers:
            raise ControllerError(f"controller '{name}' is loaded already")
        controller = self._manager.load(
            self._descriptions.find(name), self._descriptions.fallback_controllers(name))
        try:
            side = self.add(controller)
        except ControllerError:
            self._manager.unload(name)
            raise
        side.declare_parameters()

    def add(self, controller: Controller[Any]) -> ControllerNode:
        """
        Give a loaded controller a node; its parameters are declared by the caller.

        :raises ControllerError: the ROS arguments of the node cannot be read.
        """
        options = self._descriptions.node_options(controller.name)
        try:
            node = self._time.node(
                controller.name, namespace=self._namespace, cli_args=list(options))
        except RuntimeError as error:
            raise ControllerError(
                f"controller '{controller.name}': node_options_args {' '.join(options)!r} cannot "
                f'be read: {error}') from None
        side = create_controller_node(controller, node, self._dispatcher)
        self._sides = {**self._sides, controller.name: side}
        self._executor.add_node(node)
        self._open(side)
        return side

    def configure(self, name: str) -> None:
        """
        Configure a controller and create its endpoints.

        :raises ControllerError: it cannot be configured.
        """
        self._manager.configure(name)
        self._sides[name].follow_parameters()
        self.open_due()

    def open_due(self) -> None:
        """Create the endpoints of controllers whose time has come; in the executor's thread."""
        for side in self._sides.values():
            self._open(side)

    def open_due_soon(self) -> None:
        """
        Have the executor's thread create the endpoints that are due; from any thread.

        Two threads at once would give a controller two action servers.
        """
        if any(side.due for side in self.sides):
            self._executor.create_task(self.open_due)

    def unload(self, name: str) -> None:
        """
        Unload a controller and destroy its node.

        :raises ControllerError: it is active or not loaded.
        """
        self._manager.unload(name)
        side = self._sides.get(name)
        self._sides = {key: value for key, value in self._sides.items() if key != name}
        if side is not None:
            self._executor.remove_node(side.node)
            self._time.forget(side.node)
            self._dispatcher.post(side.destroy)

    def _open(self, side: ControllerNode) -> None:
        if side.due:
            side.open()
            self._opened(side.controller, side.node)

    @property
    def sides(self) -> tuple[ControllerNode, ...]:
        """A copy of all nodes, for threads other than that which loads and unloads."""
        return tuple(self._sides.values())

    def __getitem__(self, name: str) -> ControllerNode:
        """Return the ROS side of a controller."""
        return self._sides[name]

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names."""
        return iter(self._sides)

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._sides)
