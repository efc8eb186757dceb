# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Controllers and their nodes, loaded and unloaded together."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from rclpy.executors import Executor
from rclpy.node import Node

from armsim_ros.control.controller import Controller
from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.errors import ControllerError
from armsim_ros.nodes.simulation.controller_manager.descriptions import ControllerDescriptions
from armsim_ros.nodes.simulation.controllers.controller_nodes import (
    ControllerNode,
    create_controller_node,
)
from armsim_ros.nodes.simulation.dispatcher import Dispatcher
from armsim_ros.nodes.simulation.sim_time import SimTime


class ControllerRegistry(Mapping[str, ControllerNode]):
    """
    The node of each controller, in the order of loading.

    :param manager: loads and unloads the controllers.
    :param descriptions: find the settings of a controller that is to be loaded.
    :param executor: serves their nodes.
    :param namespace: where their nodes live.
    :param opened: gets each controller and its node once its own endpoints exist.
    """

    def __init__(
        self,
        manager: ControllerManager,
        descriptions: ControllerDescriptions,
        executor: Executor,
        dispatcher: Dispatcher,
        namespace: str,
        time: SimTime,
        opened: Callable[[Controller[Any], Node], object] = lambda *_: None,
    ) -> None:
        self._opened = opened
        self._time = time
        self._manager = manager
        self._descriptions = descriptions
        self._executor = executor
        self._dispatcher = dispatcher
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
