# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What clients serve: the common part of services and actions."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
import itertools
from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.task import Future

from armsim_ros.nodes.bridge.client import Client
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.refusal import Level, RefusalError
from armsim_ros.nodes.polling_node import keep_live


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
        """
        Serve ``advertise_service`` and ``advertise_action``.

        :raises RefusalError: another client serves it, or there is no such type.
        """
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
        """
        Serve ``unadvertise_service`` and ``unadvertise_action``.

        :raises RefusalError: as a warning, the client does not serve it.
        """
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
