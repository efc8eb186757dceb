# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The service ``/simulation/digest``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from std_srvs.srv import Trigger

from armsim_ros.errors import SimulationError
from armsim_ros.nodes.simulation.world.work import Work


class Digest:
    """
    Answers with a hash of plant, drives, controllers and time; equal runs have equal ones.

    :param node: the node that serves.
    :param digest: makes the hash; called between two ticks.
    """

    def __init__(
        self, node: Node, work: Work, digest: Callable[[], str]
    ) -> None:
        self._work = work
        self._digest = digest
        node.create_service(  # type: ignore[misc] # rclpy annotates no coroutine
            Trigger, '/simulation/digest', self._answer,
            callback_group=ReentrantCallbackGroup(),
        )

    async def _answer(self, _: Any, response: Trigger.Response) -> Trigger.Response:
        try:
            response.message = await self._work.in_loop(self._digest)
            response.success = True
        except SimulationError as error:
            response.message = str(error)
        return response
