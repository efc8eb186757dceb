# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Goals that clients send: ``send_action_goal``, ``cancel_action_goal``."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from dataclasses import dataclass
import time
from typing import Any

from rcl_interfaces.msg import Log
from rclpy.qos import QoSDurabilityPolicy, QoSProfile

from armsim_ros.clients.node import GoalRun
from armsim_ros.nodes.bridge.client import Client
from armsim_ros.nodes.bridge.conversion.aside import message_of
from armsim_ros.nodes.bridge.conversion.outgoing import values_of
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.refusal import Level, RefusalError
from armsim_ros.nodes.bridge.rosapi.graph import Graph

#: How long a goal of a client that has left can still be cancelled [s].
_MEMORY = 600.0
_REJECTED = 'the server rejected the goal'
#: Nodes keep what they have logged for late subscribers.
_LOG = QoSProfile(depth=1000, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
#: How long the log may take to arrive [s].
_PATIENCE = 0.7


@dataclass(eq=False)
class Goal:
    """A goal that has not ended."""

    client: Client
    action: str
    key: Any
    run: GoalRun


class Goals:
    """
    The goals of all clients, any number at a time; a goal outlives its connection.

    :param cancel_on_disconnect: whether goals of a client that leaves are cancelled.
    """

    def __init__(self, link: BridgeLink, cancel_on_disconnect: bool) -> None:
        self._link = link
        self._cancel_on_disconnect = cancel_on_disconnect
        self._goals: set[Goal] = set()
        self._tasks: set[asyncio.Task[None]] = set()

    def start(self, work: Coroutine[Any, Any, None]) -> None:
        """Do something that goes on when its client has left."""
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def cancel(self, client: Client, message: dict[str, Any]) -> None:
        """
        Serve ``cancel_action_goal``: of an own goal, else of the only goal of this id.

        :raises RefusalError: as a warning, there is none, or several clients have this id.
        """
        action, key = self._link.expand(message['action']), message.get('id')
        known = [goal for goal in self._goals if goal.action == action
                 and (key is None or goal.key == key)]
        found = [goal for goal in known if goal.client is client]
        if not found and key is not None:
            found = [goal for goal in known if not goal.client.is_open] or known
            if len({goal.client for goal in found}) > 1:
                raise RefusalError(f'several clients have a goal with id {key!r}', Level.WARNING)
        if not found:
            raise RefusalError(f'no goal with id {key!r} is under way', Level.WARNING)
        for goal in found:
            goal.run.cancel()

    def drop(self, client: Client) -> None:
        """Let the goals of a client go on without it, for a while within reach of others."""
        for goal in [each for each in self._goals if each.client is client]:
            if self._cancel_on_disconnect:
                goal.run.cancel()
            asyncio.get_running_loop().call_later(_MEMORY, self._goals.discard, goal)

    def close(self) -> None:
        """Wait for nothing any more."""
        for task in self._tasks:
            task.cancel()

    async def send(self, client: Client, message: dict[str, Any]) -> None:
        """
        Serve ``send_action_goal`` until the goal has ended.

        :raises ArmsimError: there is no such action, or the goal does not fit or was rejected.
        """
        action = self._link.expand(message['action'])
        kind = await self._link.load(message['action_type'], 'action')
        request = await message_of(kind.Goal, message.get('args') or {}, self._link.now)
        await self._link.wait_for_action(kind, action)
        feedback = None
        if message.get('feedback'):
            def feedback(values: Any) -> None:
                self._link.schedule(lambda: self._feedback(client, message, values))
        sent = time.time_ns()
        run = self._link.goal(kind, action, request, feedback)
        goal = Goal(client, action, message.get('id'), run)
        self._goals.add(goal)
        try:
            found = await self._outcome(kind, action, run)
        finally:
            self._goals.discard(goal)
        if found is None:
            reason = await logged_error(self._link, action, sent)
            raise RefusalError(f'{_REJECTED}: {reason}' if reason else _REJECTED)
        await client.answer_with(message, {
            'op': 'action_result', 'action': message['action'], 'status': found.status,
            'result': True}, found.result)

    async def _outcome(self, kind: type[Any], action: str, run: GoalRun) -> Any:
        waiting = asyncio.wrap_future(run.result)
        missing = 0
        while missing < 2:
            done, _ = await asyncio.wait([waiting], timeout=1.0)
            if done:
                return waiting.result()
            missing = 0 if self._link.serves(kind, action, action=True) else missing + 1
        raise RefusalError('the server has gone without a result')

    def _feedback(self, client: Client, message: dict[str, Any], values: Any) -> None:
        client.answer(message, {'op': 'action_feedback', 'action': message['action'],
                                'values': values_of(values)})


async def logged_error(link: BridgeLink, action: str, since: int) -> str:
    """
    Return the error that an action's server has logged, '' where there is none.

    A rejection has no text, but the log has.

    :param action: full name.
    :param since: what is older is another's [ns], of the system's clock.
    """
    servers = [node.strip('/').replace('/', '.')
               for node in Graph(link).providers([f'{action}/_action/send_goal'])]
    found: asyncio.Future[str] = link.loop.create_future()

    def settle(text: str) -> None:
        if not found.done():
            found.set_result(text)

    def receive(message: Log) -> None:
        stamp = message.stamp.sec * 10**9 + message.stamp.nanosec
        if message.level >= Log.ERROR and stamp >= since and any(
                f'{message.name}.'.startswith(f'{server}.') for server in servers):
            link.schedule(lambda: settle(message.msg))

    subscription = await link.run(
        lambda: link.node.create_subscription(Log, '/rosout', receive, _LOG))
    try:
        return await asyncio.wait_for(found, _PATIENCE)
    except (asyncio.TimeoutError, TimeoutError):
        return ''
    finally:
        link.in_thread(lambda: link.node.destroy_subscription(subscription))
