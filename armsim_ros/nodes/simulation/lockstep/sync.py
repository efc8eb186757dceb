# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The service ``/simulation/sync``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from std_srvs.srv import Trigger

from armsim_ros.errors import SimulationError
from armsim_ros.nodes.simulation.world.work import Work


class Sync:
    """
    Publishes ``/clock`` and the joint states as they are now, and answers with their time.

    Topics have no answer; a client that needs the present state waits for the message
    with this time.

    :param node: the node that serves.
    :param publish: hands the messages to the publishing thread and returns their time [ns];
        called between two ticks.
    """

    def __init__(
        self, node: Node, work: Work, publish: Callable[[], int]
    ) -> None:
        self._work = work
        self._publish = publish
        node.create_service(  # type: ignore[misc] # rclpy annotates no coroutine
            Trigger, '/simulation/sync', self._answer,
            callback_group=ReentrantCallbackGroup(),
        )

    async def _answer(self, _: Any, response: Trigger.Response) -> Trigger.Response:
        try:
            response.message = str(await self._work.in_loop(self._publish))
            response.success = True
        except SimulationError as error:
            response.message = str(error)
        return response
