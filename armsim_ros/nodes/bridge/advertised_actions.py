# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Actions that clients serve: ``advertise_action``, ``action_feedback``, ``action_result``."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
import itertools
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.task import Future

from armsim_ros.nodes import qos
from armsim_ros.nodes.bridge.client import Client
from armsim_ros.nodes.bridge.conversion.incoming import to_message
from armsim_ros.nodes.bridge.conversion.outgoing import json_values
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.refusal import Level, RefusalError

#: Time to request the results of aborted goals before the action is gone [s].
_LAST_RESULTS = 0.5


@dataclass
class ServedAction:
    """An action of a client, and the goals that wait for its results."""

    client: Client
    name: str
    kind: type[Any]
    server: Any = None
    goals: dict[str, tuple[ServerGoalHandle, Future]] = field(default_factory=dict)


class AdvertisedActions:
    """The actions of all clients; a name belongs to the client that advertised it first."""

    def __init__(self, link: BridgeLink) -> None:
        self._link = link
        self._group = ReentrantCallbackGroup()
        self._served: dict[str, ServedAction] = {}
        self._numbers = itertools.count(1)

    async def advertise(self, client: Client, message: dict[str, Any]) -> None:
        """
        Serve ``advertise_action``.

        :raises RefusalError: another client serves it, or there is no such type.
        """
        name = self._link.expand(message['action'])
        kind = await self._link.load(message['type'], 'action')
        before = self._served.get(name)
        if before is not None and before.client is not client:
            raise RefusalError('another client serves it')
        if before is not None:
            await self._end(before)
        served = self._served[name] = ServedAction(client, message['action'], kind)

        async def execute(goal: ServerGoalHandle) -> Any:
            return await self._execute(served, goal)

        def make() -> ActionServer:
            return ActionServer(
                self._link.node, kind, name, execute, callback_group=self._group,
                cancel_callback=lambda goal: self._cancel(served, goal), **qos.ACTION_SERVICES)

        served.server = await self._link.run(make)
        if not client.is_open or self._served.get(name) is not served:
            await self._end(served)

    async def unadvertise(self, client: Client, message: dict[str, Any]) -> None:
        """
        Serve ``unadvertise_action``.

        :raises RefusalError: as a warning, the client does not serve it.
        """
        served = self._served.get(self._link.expand(message['action']))
        if served is None or served.client is not client:
            raise RefusalError('it is not advertised', Level.WARNING)
        await self._end(served)

    async def feedback(self, client: Client, message: dict[str, Any]) -> None:
        """
        Serve ``action_feedback``.

        :raises RefusalError: there is no such goal.
        :raises ConversionError: the values do not fit.
        """
        served, key = self._find(client, message)
        values = to_message(served.kind.Feedback, message.get('values') or {}, self._link.now)
        goal = served.goals[key][0]
        self._link.in_thread(lambda: goal.is_active and goal.publish_feedback(values))

    async def result(self, client: Client, message: dict[str, Any]) -> None:
        """
        Serve ``action_result``.

        :raises RefusalError: there is no such goal.
        :raises ConversionError: the values do not fit; the goal is aborted.
        """
        served, key = self._find(client, message)
        _, waiting = served.goals.pop(key)
        outcome: tuple[int, Any] = GoalStatus.STATUS_ABORTED, None
        try:
            if message.get('result', True):
                values = to_message(served.kind.Result, message.get('values') or {},
                                    self._link.now)
                status = message.get('status', GoalStatus.STATUS_SUCCEEDED)
                outcome = status if isinstance(status, int) else 0, values
        finally:
            self._link.settle(waiting, outcome)

    async def drop(self, client: Client) -> None:
        """End all actions of a client; their goals are aborted."""
        for served in [each for each in self._served.values() if each.client is client]:
            await self._end(served)

    def _find(self, client: Client, message: dict[str, Any]) -> tuple[ServedAction, str]:
        key = str(message.get('id'))
        for served in self._served.values():
            if served.client is client and key in served.goals:
                return served, key
        raise RefusalError(f'no goal with id {key[:100]!r} is under way', Level.WARNING)

    async def _end(self, served: ServedAction) -> None:
        for name, other in list(self._served.items()):
            if other is served:
                del self._served[name]
        aborted = list(served.goals.values())
        served.goals.clear()
        for _, waiting in aborted:
            self._link.settle(waiting, (GoalStatus.STATUS_ABORTED, None))
        if aborted:
            # Callers that were accepted a moment ago have yet to request the result.
            await asyncio.sleep(_LAST_RESULTS)
        for _ in range(3):
            await self._link.run(lambda: None)
        if served.server is not None:
            await self._link.run(lambda: served.server.destroy())

    async def _execute(self, served: ServedAction, goal: ServerGoalHandle) -> Any:
        """Let the client do it; in the node's thread."""
        waiting, key = Future(), f'action_goal:{served.name}:{next(self._numbers)}'
        goal.bridge_key = key  # type: ignore[attr-defined] # for the request to cancel it

        def send() -> None:
            if not served.client.is_open:
                self._link.settle(waiting, (GoalStatus.STATUS_ABORTED, None))
                return
            served.goals[key] = goal, waiting
            served.client.send({
                'op': 'send_action_goal', 'id': key, 'action': served.name,
                'action_type': '/'.join(_parts(served.kind)), 'feedback': True,
                'args': json_values(served.kind.Goal)(goal.request)})

        self._link.schedule(send)
        status, result = await waiting
        if status == GoalStatus.STATUS_SUCCEEDED:
            goal.succeed()
        elif status == GoalStatus.STATUS_CANCELED and goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()
        return served.kind.Result() if result is None else result

    def _cancel(self, served: ServedAction, goal: ServerGoalHandle) -> CancelResponse:
        key = getattr(goal, 'bridge_key', '')
        self._link.schedule(lambda: served.client.send(
            {'op': 'cancel_action_goal', 'id': key, 'action': served.name}))
        return CancelResponse.ACCEPT


def _parts(kind: type[Any]) -> tuple[str, str, str]:
    package, group = kind.__module__.split('.')[:2]
    return package, group, kind.__name__
