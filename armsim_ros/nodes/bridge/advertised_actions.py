# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Actions that clients serve: ``advertise_action``, ``action_feedback``, ``action_result``."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle

from armsim_ros.nodes import qos
from armsim_ros.nodes.bridge.advertised import Advertised, Served
from armsim_ros.nodes.bridge.client import Client
from armsim_ros.nodes.bridge.conversion.aside import message_of
from armsim_ros.nodes.bridge.conversion.fields import type_name
from armsim_ros.nodes.bridge.conversion.outgoing import values_of

#: Time to request the results of aborted goals before the action is gone [s].
_LAST_RESULTS = 0.5


class AdvertisedActions(Advertised):
    """The actions of all clients."""

    word, types, prefix = 'action', 'action', 'action_goal'

    async def feedback(self, client: Client, message: dict[str, Any]) -> None:
        """
        Serve ``action_feedback``.

        :raises RefusalError: there is no such goal.
        :raises ConversionError: the values do not fit.
        """
        served, key = self._find(client, message)
        goal = served.requests[key][0]
        values = await message_of(served.kind.Feedback, message.get('values') or {},
                                  self._link.now)
        self._link.in_thread(lambda: goal.is_active and goal.publish_feedback(values))

    async def result(self, client: Client, message: dict[str, Any]) -> None:
        """
        Serve ``action_result``.

        :raises RefusalError: there is no such goal.
        :raises ConversionError: the values do not fit; the goal is aborted.
        """
        served, key = self._find(client, message)
        _, waiting = served.requests.pop(key)
        outcome = None
        try:
            if message.get('result', True):
                outcome = (message.get('status', GoalStatus.STATUS_SUCCEEDED), await message_of(
                    served.kind.Result, message.get('values') or {}, self._link.now))
        finally:
            self._link.settle(waiting, outcome)

    async def _settle_all(self, served: Served) -> None:
        waited_for = bool(served.requests)
        await super()._settle_all(served)
        if waited_for:
            # Callers that were accepted a moment ago have yet to request the result.
            await asyncio.sleep(_LAST_RESULTS)
        for _ in range(2):
            await self._link.run(lambda: None)

    def _make(self, served: Served, name: str) -> Callable[[], Any]:
        async def execute(goal: ServerGoalHandle) -> Any:
            key, answer = self._request(served, goal, {
                'op': 'send_action_goal', 'action_type': type_name(served.kind), 'feedback': True,
                'args': values_of(goal.request)})
            goal.bridge_key = key  # type: ignore[attr-defined] # for the request to cancel it
            status, result = await answer or (GoalStatus.STATUS_ABORTED, served.kind.Result())
            if status == GoalStatus.STATUS_SUCCEEDED:
                goal.succeed()
            elif status == GoalStatus.STATUS_CANCELED and goal.is_cancel_requested:
                goal.canceled()
            else:
                goal.abort()
            return result

        def cancel(goal: ServerGoalHandle) -> CancelResponse:
            key = getattr(goal, 'bridge_key', '')
            self._link.schedule(lambda: served.client.send(
                {'op': 'cancel_action_goal', 'id': key, 'action': served.name}))
            return CancelResponse.ACCEPT

        server = ActionServer(
            self._link.node, served.kind, name, execute, callback_group=self._group,
            cancel_callback=cancel, **qos.ACTION_SERVICES)
        return server.destroy
