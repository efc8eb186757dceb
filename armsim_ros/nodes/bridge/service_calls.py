# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Services that clients call: ``call_service``."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.bridge.client import Client
from armsim_ros.nodes.bridge.conversion.incoming import to_message
from armsim_ros.nodes.bridge.conversion.outgoing import json_values, with_old_names
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
        """Serve ``call_service``: the answer follows when there is one."""
        client.start(self._call(client, message))

    async def _call(self, client: Client, message: dict[str, Any]) -> None:
        service = message['service']
        answer = {'op': 'service_response', 'service': service}
        if 'id' in message:
            answer['id'] = message['id']
        patience = float(message.get('timeout') or self._patience)
        try:
            values = await asyncio.wait_for(self._values(service, message.get('args')),
                                            patience or None)
            answer |= {'values': values, 'result': True}
        except (asyncio.TimeoutError, TimeoutError):
            answer |= {'values': f'{service}: no answer within {patience:g} s', 'result': False}
        except ArmsimError as error:
            answer |= {'values': f'{service}: {error}', 'result': False}
        except Exception as error:  # noqa: BLE001 - the client waits
            answer |= {'values': f'{service}: failed inside the bridge: {error}', 'result': False}
        client.send(answer, compression='png' if message.get('compression') == 'png' else 'none',
                    fragment_size=message.get('fragment_size') or 0)

    async def _values(self, service: str, args: Any) -> Any:
        name = self._link.expand(service, service=True)
        values = {} if args is None else args
        if name in self._local:
            kind, respond = self._local[name]
            response = await respond(to_message(kind.Request, values, self._link.now))
            found = json_values(kind.Response)(response)
            if set(found) == {'time'}:  # roslibpy reads the names of ROS 1
                found['time'] = with_old_names(found['time'])
            return found
        kind = await self._kind(name)
        request = to_message(kind.Request, values, self._link.now)
        response = await self._link.call_when_ready(kind, name, request)
        return json_values(kind.Response)(response)

    async def _kind(self, name: str) -> type[Any]:
        """Return a service's class; it is not searched for again while it is served."""
        kind = self._kinds.get(name)
        if kind is None or not self._link.serves(kind, name):
            found = await self._link.service_type(name)
            kind = self._kinds[name] = await self._link.load(found, 'srv')
        return kind


def check_args(args: Any) -> None:
    """
    Check the form of a call's arguments.

    :raises RefusalError: it is neither an object nor a list.
    """
    if args is not None and not isinstance(args, (dict, list)):
        raise RefusalError(f'args is an object or a list, not {type(args).__name__}')
