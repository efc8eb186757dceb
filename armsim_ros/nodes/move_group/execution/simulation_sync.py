# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Asks ``/simulation/sync`` for the time where time only moves in steps."""

from __future__ import annotations

from std_srvs.srv import Trigger

from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.nodes import qos
from armsim_ros.nodes.move_group.context import Context

#: Wall time to wait for the simulation [s].
ANSWER_TIMEOUT = 5.0


class SimulationSync:
    """
    Finds out which joint states are current.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self._client = context.node.create_client(
            Trigger, '/simulation/sync', qos_profile=qos.SERVICES, callback_group=context.group
        )

    async def __call__(self) -> int:
        """
        Return the simulation's time [ns]; the joint states of it are on their way.

        :raises PlanningError: no answer.
        """
        clock, ticker = self._context.clock, self._context.ticker
        deadline = clock() + ANSWER_TIMEOUT
        while not self._client.service_is_ready() and clock() < deadline:
            await ticker.next()
        answer = self._client.call_async(Trigger.Request())
        while not answer.done() and clock() < deadline:
            await ticker.next()
        if not answer.done() or not answer.result().success:
            raise PlanningError(
                MoveItErrorCode.ROBOT_STATE_STALE,
                "the simulation does not answer on '/simulation/sync'; does it run in lockstep?",
                'joint_states',
            )
        return int(answer.result().message)
