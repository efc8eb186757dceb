# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What clients serve: ``advertise_service``, ``advertise_action``, and their answers."""

from __future__ import annotations

from abc import ABC, abstractmethod
import asyncio
from collections.abc import Callable
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
from armsim_ros.nodes.bridge.incoming import message_of
from armsim_ros.nodes.bridge.interfaces import Level, RefusalError
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.message_fields import type_name
from armsim_ros.nodes.bridge.outgoing import values_of
from armsim_ros.nodes.polling_node import keep_live

#: How long a client may take for an answer where no time is configured [s].
_PATIENCE = 30.0
#: Time to send answers, and to request results of aborted goals, before an endpoint is gone [s].
_LAST_ANSWERS = 0.5


@dataclass(eq=False)
class Served:
    """
    An endpoint of a client; id of a request -> its goal, if any, and what waits for it.

    :param destroy: takes the endpoint away; in the node's thread.
    """

    client: Client
    name: str
    kind: type[Any]
    destroy: Callable[[], Any] = lambda: None
    requests: dict[str, tuple[Any, Future]] = field(default_factory=dict)


class Advertised(ABC):
    """The endpoints of all clients; a name belongs to the client that advertised it first."""

    #: What an endpoint is called, the group of its types, and how ids of requests begin.
    word: str
    types: str
    prefix: str

    def __init__(self, link: BridgeLink) -> None:
        self._link = link
        self._group = keep_live(ReentrantCallbackGroup())
        self._served: dict[str, Served] = {}
        self._numbers = itertools.count(1)

    async def advertise(self, client: Client, message: dict[str, Any]) -> None:
        """Serve ``advertise_service`` and ``advertise_action``."""
        name = self._expanded(message)
        kind = await self._link.load(message['type'], self.types)
        before = self._served.get(name)
        if before is not None and before.client is not client:
            raise RefusalError('another client serves it')
        if before is not None:
            await self._end(before)
        served = self._served[name] = Served(client, message[self.word], kind)
        served.destroy = await self._link.run(lambda: self._make(served, name))

    async def unadvertise(self, client: Client, message: dict[str, Any]) -> None:
        """Serve ``unadvertise_service`` and ``unadvertise_action``."""
        served = self._served.get(self._expanded(message))
        if served is None or served.client is not client:
            raise RefusalError('it is not advertised', Level.WARNING)
        await self._end(served)

    async def drop(self, client: Client) -> None:
        """End all that a client serves."""
        for served in [each for each in self._served.values() if each.client is client]:
            await self._end(served)

    @abstractmethod
    def _make(self, served: Served, name: str) -> Callable[[], Any]:
        """Make the endpoint and return what takes it away; in the node's thread."""

    async def _settle_all(self, served: Served) -> None:
        """Let everything that waits for a client go on without it."""
        requests = list(served.requests.values())
        served.requests.clear()
        for _, waiting in requests:
            self._link.settle(waiting, None)
        # What is settled is answered before the endpoint goes.
        await self._link.run(lambda: None)
        if requests:
            # The middleware sends answers in its own thread, and drops them with the endpoint;
            # callers of actions that were accepted a moment ago have yet to request the result.
            await asyncio.sleep(_LAST_ANSWERS)

    async def _end(self, served: Served) -> None:
        self._served = {name: other for name, other in self._served.items()
                        if other is not served}
        await self._settle_all(served)
        await self._link.run(served.destroy)

    def _find(self, client: Client, message: dict[str, Any]) -> tuple[Served, str]:
        """
        Return what a message of a client answers, and its id.

        :raises RefusalError: as a warning, nothing waits for it.
        """
        key = str(message.get('id'))
        for served in self._served.values():
            if served.client is client and key in served.requests:
                return served, key
        raise RefusalError(f'no request with id {key[:100]!r} waits', Level.WARNING)

    def _succeeded(self, message: dict[str, Any]) -> bool:
        """Return whether an answer holds values; null counts as missing."""
        return message.get('result') is not False

    async def _answer(self, client: Client, message: dict[str, Any], part: str) -> None:
        """Let what waits go on, with status and message, or None where the client failed."""
        served, key = self._find(client, message)
        _, waiting = served.requests.pop(key)
        answer = None
        try:
            if self._succeeded(message):
                answer = message.get('status', GoalStatus.STATUS_SUCCEEDED), await message_of(
                    getattr(served.kind, part), message.get('values') or {}, self._link.now)
        finally:
            self._link.settle(waiting, answer)

    def _request(self, served: Served, goal: Any, message: dict[str, Any], patience: float = 0.0
                 ) -> tuple[str, Future]:
        """
        Ask the client; in the node's thread.

        :param patience: how long it may take; 0 for ever [s].
        :returns: the request's id, and what becomes its answer, None where there is none.
        """
        waiting, key = Future(), f'{self.prefix}:{served.name}:{next(self._numbers)}'

        def send() -> None:
            if not served.client.is_open:
                self._link.settle(waiting, None)
                return
            served.requests[key] = goal, waiting
            served.client.send({'id': key, self.word: served.name, **message})
            if patience:
                self._link.loop.call_later(patience, give_up)

        def give_up() -> None:
            if served.requests.pop(key, None) is not None:
                self._link.settle(waiting, None)

        self._link.schedule(send)
        return key, waiting

    def _expanded(self, message: dict[str, Any]) -> str:
        return self._link.expand(message[self.word], service=self.word == 'service')


class AdvertisedServices(Advertised):
    """
    The services of all clients.

    :param patience: the longest wait for a client's answer; 0 for the usual time [s].
    """

    word, types, prefix = 'service', 'srv', 'service_request'

    def __init__(self, link: BridgeLink, patience: float) -> None:
        super().__init__(link)
        self._patience = patience or _PATIENCE

    async def respond(self, client: Client, message: dict[str, Any]) -> None:
        """Serve ``service_response``; the caller gets default values where it does not fit."""
        await self._answer(client, message, 'Response')

    def _succeeded(self, message: dict[str, Any]) -> bool:
        # A response that reports a failure has values, too.
        return bool(message.get('values')) or super()._succeeded(message)

    def _make(self, served: Served, name: str) -> Callable[[], Any]:
        async def respond(request: Any, response: Any) -> Any:
            _, answer = self._request(
                served, None, {'op': 'call_service', 'args': values_of(request)}, self._patience)
            found = await answer
            if found is None:
                self._link.node.get_logger().warning(
                    f'{served.name}: the client did not answer; the caller gets default values')
            return response if found is None else found[1]

        service = self._link.node.create_service(served.kind, name, respond,
                                                 callback_group=self._group)
        return lambda: self._link.node.destroy_service(service)


class AdvertisedActions(Advertised):
    """The actions of all clients."""

    word, types, prefix = 'action', 'action', 'action_goal'

    async def feedback(self, client: Client, message: dict[str, Any]) -> None:
        """Serve ``action_feedback``."""
        served, key = self._find(client, message)
        goal = served.requests[key][0]
        values = await message_of(served.kind.Feedback, message.get('values') or {},
                                  self._link.now)
        self._link.in_thread(lambda: goal.is_active and goal.publish_feedback(values))

    async def result(self, client: Client, message: dict[str, Any]) -> None:
        """Serve ``action_result``; the goal is aborted where it does not fit."""
        await self._answer(client, message, 'Result')

    async def _settle_all(self, served: Served) -> None:
        await super()._settle_all(served)
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
