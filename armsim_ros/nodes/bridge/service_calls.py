# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Services that clients call: ``call_service``."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from armsim_ros.nodes.bridge.client import Client
from armsim_ros.nodes.bridge.conversion.aside import message_of
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.refusal import RefusalError

#: Name of a service of this process -> its type, and what answers it.
LocalServices = Mapping[str, tuple[type[Any], Callable[[Any], Awaitable[Any]]]]


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
        """
        Serve ``call_service``.

        :raises ArmsimError: there is no such service, its request does not fit, or it is late.
        """
        service = message['service']
        name = self._link.expand(service, service=True)
        patience = float(message.get('timeout') or self._patience)
        try:
            response = await asyncio.wait_for(self._response(name, message.get('args')),
                                              patience or None)
        except (asyncio.TimeoutError, TimeoutError):
            raise RefusalError(f'no answer within {patience:g} s') from None
        await client.answer_with(
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
