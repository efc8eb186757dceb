# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Services that clients serve: ``advertise_service``, ``service_response``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from armsim_ros.nodes.bridge.advertised import Advertised, Served
from armsim_ros.nodes.bridge.client import Client
from armsim_ros.nodes.bridge.conversion.aside import message_of
from armsim_ros.nodes.bridge.conversion.outgoing import values_of
from armsim_ros.nodes.bridge.link import BridgeLink

#: How long a client may take for an answer where no time is configured [s].
_PATIENCE = 30.0


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
        """
        Serve ``service_response``.

        :raises RefusalError: no request of this id waits.
        :raises ConversionError: the values do not fit; the caller gets default values.
        """
        served, key = self._find(client, message)
        _, waiting = served.requests.pop(key)
        response = None
        try:
            if message.get('result', True):
                response = await message_of(served.kind.Response, message.get('values') or {},
                                      self._link.now)
        finally:
            self._link.settle(waiting, response)

    def _make(self, served: Served, name: str) -> Callable[[], Any]:
        async def respond(request: Any, response: Any) -> Any:
            _, answer = self._request(
                served, None, {'op': 'call_service',
                               'args': values_of(request)}, self._patience)
            found = await answer
            if found is None:
                self._link.node.get_logger().warning(
                    f'{served.name}: the client did not answer; the caller gets default values')
            return response if found is None else found

        service = self._link.node.create_service(served.kind, name, respond,
                                                 callback_group=self._group)
        return lambda: self._link.node.destroy_service(service)
