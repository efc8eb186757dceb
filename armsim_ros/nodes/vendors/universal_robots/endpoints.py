# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""All endpoints of an arm of Universal Robots."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from std_msgs.msg import Bool

from armsim_ros.control.controller import Controller
from armsim_ros.errors import SimulationError
from armsim_ros.nodes.vendors.endpoints import ArmNodes, Endpoints
from armsim_ros.nodes.vendors.universal_robots.dashboard import Dashboard, StateHelper
from armsim_ros.nodes.vendors.universal_robots.io_and_status import IoAndStatus
from armsim_ros.nodes.vendors.universal_robots.urscript import UrScript

#: Freedrive ends so long after the last message that asked for it [ns].
TIMEOUT_NS = 1_000_000_000


class Freedrive:
    """The topic of a ``ur_controllers/FreedriveModeController``."""

    def __init__(self, nodes: ArmNodes, controller: Controller[Any], node: Node) -> None:
        self._nodes, self._controller = nodes, controller
        self._last_ns = 0
        receive: Any = self._receive  # an executor runs coroutines, too
        node.create_subscription(Bool, '~/enable_freedrive_mode', receive, 10)

    def publish(self, time_ns: int) -> None:
        """End freedrive once nothing has asked for it in time, or the controller is inactive."""
        if self._nodes.arm.freedrive and not (
                self._controller.active and 0 <= time_ns - self._last_ns < TIMEOUT_NS):
            self._nodes.loop.call(lambda: self._nodes.arm.set_freedrive(False))

    async def _receive(self, message: Bool) -> None:
        arm = self._nodes.arm
        self._last_ns = self._nodes.time_ns
        if message.data == arm.freedrive or not self._controller.active:
            return
        if message.data and arm.obstacle:
            self._controller.events.add(self._last_ns, 'warning', 'warning',
                                        f'no freedrive: {arm.obstacle}')
            return
        try:
            await self._nodes.change(lambda: arm.set_freedrive(message.data))
        except SimulationError:
            return


class UniversalRobots(Endpoints):
    """Dashboard, state helper and URScript of an arm, and what its controllers offer."""

    def __init__(self, nodes: ArmNodes) -> None:
        super().__init__(nodes)
        self._controllers: list[IoAndStatus | Freedrive] = []

    def create(self) -> None:
        """Create the nodes that are programs of their own beside the real arm."""
        Dashboard(self.nodes)
        self._helper = StateHelper(self.nodes)
        UrScript(self.nodes)

    def open(self, controller: Controller[Any], node: Node) -> None:
        """Create what a controller of ``ur_controllers`` offers."""
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
