# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""All endpoints of an arm of Universal Robots."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node

from armsim_ros.control.controller import Controller
from armsim_ros.nodes.vendors.endpoints import ArmNodes, Endpoints
from armsim_ros.nodes.vendors.universal_robots.dashboard import Dashboard
from armsim_ros.nodes.vendors.universal_robots.freedrive import Freedrive
from armsim_ros.nodes.vendors.universal_robots.io_and_status import IoAndStatus
from armsim_ros.nodes.vendors.universal_robots.state_helper import StateHelper
from armsim_ros.nodes.vendors.universal_robots.urscript import UrScript


class UniversalRobots(Endpoints):
    """Dashboard, state helper and URScript of an arm, and what its controllers offer."""

    def create(self) -> None:
        """Create the nodes that are programs of their own beside the real arm."""
        self._controllers: list[IoAndStatus | Freedrive] = getattr(self, '_controllers', [])
        Dashboard(self.nodes)
        self._helper = StateHelper(self.nodes)
        UrScript(self.nodes)

    def open(self, controller: Controller[Any], node: Node) -> None:
        """Create what a controller of ``ur_controllers`` offers."""
        self._controllers = getattr(self, '_controllers', [])
        kind = controller.type.rpartition('/')[2]
        if kind == 'GPIOController':
            self._controllers.append(IoAndStatus(self.nodes, controller, node))
        elif kind == 'FreedriveModeController':
            self._controllers.append(Freedrive(self.nodes, controller, node))

    def publish(self, time_ns: int) -> None:
        """Publish states, and end a freedrive that nothing keeps alive."""
        for side in self._controllers:
            side.publish(time_ns)
        self.nodes.check_waiting()

    @property
    def pending(self) -> int:
        """Goals of ``set_mode`` without a result."""
        return self._helper.pending


def create(nodes: ArmNodes) -> Endpoints:
    """Return the endpoints of an arm."""
    return UniversalRobots(nodes)
