# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What clients use: ``call_service``, ``send_action_goal``, ``cancel_action_goal``."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Coroutine, Mapping
from dataclasses import dataclass
import time
from typing import Any

from action_msgs.msg import GoalStatus
from rcl_interfaces.msg import Log
from rclpy.qos import QoSDurabilityPolicy, QoSProfile

from armsim_ros.clients.node import GoalRun
from armsim_ros.nodes.bridge.client import Client
from armsim_ros.nodes.bridge.incoming import message_of
from armsim_ros.nodes.bridge.interfaces import Level, RefusalError
from armsim_ros.nodes.bridge.link import BridgeLink

#: Name of a service of this process -> its type, and what answers it.
LocalServices = Mapping[str, tuple[type[Any], Callable[[Any], Awaitable[Any]]]]
#: How long a goal of a client that has left can still be cancelled [s].
_MEMORY = 600.0
_REJECTED = 'the server rejected the goal'
#: Nodes keep what they have logged for late subscribers.
_LOG = QoSProfile(depth=1000, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
#: How long the log may take to arrive [s].
_PATIENCE = 0.7


class ServiceCalls:
    """
    Calls of all clients, any number at a time.

    :param local: services that are answered without the middleware.
    :param patience: the longest wait where a call names none; 0 for ever [s].
    """

    def __init__(self, link: BridgeLink, local: LocalServices, patience: float) -> None:
        self._link, self._local, self._patience = link, local, patience
        self._kinds: dict[str, type[Any]] = {}

    async def call(self, client: Client, message: dict[str, Any]) -> None:
        """Serve ``call_service``."""
        service = message['service']
        name = self._link.expand(service, service=True)
        given = message.get('timeout')
        # As roslib documents it: a non-positive value means no timeout.
        patience = self._patience if given is None else max(0.0, given)
        try:
            response = await asyncio.wait_for(self._response(name, message.get('args')),
                                              patience or None)
        except (asyncio.TimeoutError, TimeoutError):
            raise RefusalError(f'no answer within {patience:g} s') from None
        await client.answer(
            message, {'op': 'service_response', 'service': service, 'result': True}, response,
            compression='png' if message.get('compression') == 'png' else 'none',
            adapt=_with_old_names if name in self._local else lambda values: values)

    async def _response(self, name: str, args: Any) -> Any:
        values = {} if args is None else args
        if name in self._local:
            kind, respond = self._local[name]
            return await respond(await message_of(kind.Request, values, self._link.now))
        kind = await self._kind(name)
        request = await message_of(kind.Request, values, self._link.now)
        return await self._link.call_when_ready(kind, name, request)

    async def _kind(self, name: str) -> type[Any]:
        """Return a service's class; it is not searched for again while it is served."""
        kind = self._kinds.get(name)
        if kind is None or not self._link.serves(kind, name):
            found = await self._link.service_type(name)
            kind = self._kinds[name] = await self._link.load(found, 'srv')
        return kind


def _with_old_names(values: Any) -> Any:
    """Add the names of ROS 1 to the time, which roslibpy reads."""
    if set(values) == {'time'}:
        values['time'] |= {'secs': values['time']['sec'], 'nsecs': values['time']['nanosec']}
    return values


@dataclass(eq=False)
class Goal:
    """A goal that has not ended; without ``run`` it waits for its server."""

    client: Client
    action: str
    key: Any
    run: GoalRun | None = None
    is_canceled: bool = False

    def cancel(self) -> None:
        """Cancel the goal, or keep it from being sent."""
        self.is_canceled = True
        if self.run is not None:
            self.run.cancel()


class Goals:
    """
    The goals of all clients, any number at a time; a goal outlives its connection.

    :param cancel_on_disconnect: whether goals of a client that leaves are cancelled.
    """

    def __init__(self, link: BridgeLink, cancel_on_disconnect: bool) -> None:
        self._link, self._cancel_on_disconnect = link, cancel_on_disconnect
        self._goals: set[Goal] = set()
        self._tasks: set[asyncio.Task[None]] = set()

    def start(self, work: Coroutine[Any, Any, None]) -> None:
        """Do something that goes on when its client has left."""
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def cancel(self, client: Client, message: dict[str, Any]) -> None:
        """Serve ``cancel_action_goal``: of an own goal, else of the only goal of this id."""
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
            goal.cancel()

    def drop(self, client: Client) -> None:
        """Let the goals of a client go on without it, for a while within reach of others."""
        for goal in [each for each in self._goals if each.client is client]:
            if self._cancel_on_disconnect:
                goal.cancel()
            asyncio.get_running_loop().call_later(_MEMORY, self._goals.discard, goal)

    def close(self) -> None:
        """Wait for nothing any more."""
        for task in self._tasks:
            task.cancel()

    async def send(self, client: Client, message: dict[str, Any]) -> None:
        """Serve ``send_action_goal`` until the goal has ended."""
        goal = Goal(client, self._link.expand(message['action']), message.get('id'))
        self._goals.add(goal)
        try:
            status, result = await self._end_of(goal, message)
        finally:
            self._goals.discard(goal)
        await client.answer(message, {
            'op': 'action_result', 'action': message['action'], 'status': status,
            'result': True}, result)

    async def _end_of(self, goal: Goal, message: dict[str, Any]) -> tuple[int, Any]:
        """
        Send a goal and return its status and result.

        :raises RefusalError: there is no server, or it rejects the goal.
        """
        client, action = goal.client, goal.action
        kind = await self._link.load(message['action_type'], 'action')
        request = await message_of(kind.Goal, message.get('args') or {}, self._link.now)
        await self._link.wait_for_action(kind, action)
        if goal.is_canceled:
            return GoalStatus.STATUS_CANCELED, kind.Result()
        feedback = None
        if message.get('feedback'):
            def feedback(values: Any) -> None:
                self._link.schedule(lambda: client.start(client.answer(
                    message, {'op': 'action_feedback', 'action': message['action']}, values)))
        sent = time.time_ns()
        goal.run = self._link.goal(kind, action, request, feedback)
        found = await self._outcome(kind, action, goal.run)
        if found is None:
            reason = await logged_error(self._link, action, sent)
            raise RefusalError(f'{_REJECTED}: {reason}' if reason else _REJECTED)
        return found.status, found.result

    async def _outcome(self, kind: type[Any], action: str, run: GoalRun) -> Any:
        waiting = asyncio.wrap_future(run.result)
        missing = 0
        while missing < 2:
            done, _ = await asyncio.wait([waiting], timeout=1.0)
            if done:
                return waiting.result()
            missing = 0 if self._link.serves(kind, action, action=True) else missing + 1
        raise RefusalError('the server has gone without a result')


async def logged_error(link: BridgeLink, action: str, since: int) -> str:
    """
    Return the error that an action's server has logged, '' where there is none.

    A rejection has no text, but the log has.

    :param action: full name.
    :param since: what is older is another's [ns], of the system's clock.
    """
    servers = [node.strip('/').replace('/', '.')
               for node in link.providers([f'{action}/_action/send_goal'])]
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
