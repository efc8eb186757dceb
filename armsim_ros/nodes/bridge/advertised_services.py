# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Services that clients serve: ``advertise_service``, ``service_response``."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
import itertools
from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.task import Future

from armsim_ros.nodes.bridge.client import Client
from armsim_ros.nodes.bridge.conversion.incoming import to_message
from armsim_ros.nodes.bridge.conversion.outgoing import json_values
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.refusal import Level, RefusalError

#: How long a client may take for an answer where no time is configured [s].
_PATIENCE = 30.0


@dataclass
class Served:
    """A service of a client, and the requests that wait for its answers."""

    client: Client
    name: str
    kind: type[Any]
    service: Any = None
    waiting: dict[str, Future] = field(default_factory=dict)


class AdvertisedServices:
    """
    The services of all clients; a name belongs to the client that advertised it first.

    :param patience: the longest wait for a client's answer; 0 for the usual time [s].
    """

    def __init__(self, link: BridgeLink, patience: float) -> None:
        self._link, self._patience = link, patience or _PATIENCE
        self._group = ReentrantCallbackGroup()
        self._served: dict[str, Served] = {}
        self._numbers = itertools.count(1)

    async def advertise(self, client: Client, message: dict[str, Any]) -> None:
        """
        Serve ``advertise_service``.

        :raises RefusalError: another client serves it, or there is no such type.
        """
        name = self._link.expand(message['service'], service=True)
        kind = await self._link.load(message['type'], 'srv')
        before = self._served.get(name)
        if before is not None and before.client is not client:
            raise RefusalError('another client serves it')
        if before is not None:
            await self._end(before)
        served = self._served[name] = Served(client, message['service'], kind)

        async def respond(request: Any, response: Any) -> Any:
            return await self._respond(served, request, response)

        served.service = await self._link.run(lambda: self._link.node.create_service(
            kind, name, respond, callback_group=self._group))
        if not client.is_open or self._served.get(name) is not served:
            await self._end(served)

    async def unadvertise(self, client: Client, message: dict[str, Any]) -> None:
        """
        Serve ``unadvertise_service``.

        :raises RefusalError: as a warning, the client does not serve it.
        """
        served = self._served.get(self._link.expand(message['service'], service=True))
        if served is None or served.client is not client:
            raise RefusalError('it is not advertised', Level.WARNING)
        await self._end(served)

    async def respond(self, client: Client, message: dict[str, Any]) -> None:
        """
        Serve ``service_response``.

        :raises RefusalError: no request of this id waits.
        :raises ConversionError: the values do not fit; the caller gets default values.
        """
        key = str(message.get('id'))
        for served in self._served.values():
            if served.client is client and key in served.waiting:
                waiting = served.waiting.pop(key)
                try:
                    response = None
                    if message.get('result', True):
                        response = to_message(served.kind.Response, message.get('values') or {},
                                              self._link.now)
                finally:
                    self._link.settle(waiting, response)
                return
        raise RefusalError(f'no request with id {key[:100]!r} waits', Level.WARNING)

    async def drop(self, client: Client) -> None:
        """End all services of a client."""
        for served in [each for each in self._served.values() if each.client is client]:
            await self._end(served)

    async def _end(self, served: Served) -> None:
        for name, other in list(self._served.items()):
            if other is served:
                del self._served[name]
        for waiting in served.waiting.values():
            self._link.settle(waiting, None)
        # What is settled is answered before the endpoint goes.
        await self._link.run(lambda: None)
        if served.service is not None:
            await self._link.run(lambda: self._link.node.destroy_service(served.service))

    async def _respond(self, served: Served, request: Any, response: Any) -> Any:
        """Answer a caller; in the node's thread."""
        waiting, key = Future(), f'service_request:{served.name}:{next(self._numbers)}'

        def request_answer() -> None:
            if not served.client.is_open:
                self._link.settle(waiting, None)
                return
            served.waiting[key] = waiting
            served.client.send({
                'op': 'call_service', 'id': key, 'service': served.name,
                'args': json_values(served.kind.Request)(request)})
            asyncio.get_running_loop().call_later(self._patience, give_up)

        def give_up() -> None:
            if served.waiting.pop(key, None) is not None:
                self._link.settle(waiting, None)

        self._link.schedule(request_answer)
        found = await waiting
        if found is None:
            self._link.node.get_logger().warning(
                f'{served.name}: the client did not answer; the caller gets default values')
        return response if found is None else found


