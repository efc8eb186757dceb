# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``freedrive_mode_controller``: the arm is moved by hand while a client asks for it."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from std_msgs.msg import Bool

from armsim_ros.control.controller import Controller
from armsim_ros.errors import SimulationError
from armsim_ros.nodes.vendors.endpoints import ArmNodes

#: Freedrive ends so long after the last message that asked for it [ns].
TIMEOUT_NS = 1_000_000_000


class Freedrive:
    """
    The topic of a ``ur_controllers/FreedriveModeController``.

    :param node: the controller's node.
    """

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
