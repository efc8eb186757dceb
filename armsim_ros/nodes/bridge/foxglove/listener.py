# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What clients of Foxglove do, passed on from the SDK's threads."""

from __future__ import annotations

from functools import partial
from typing import Any, TYPE_CHECKING

from foxglove.websocket import ServerListener

from armsim_ros.nodes.bridge.foxglove.commands import Commands

if TYPE_CHECKING:
    from armsim_ros.nodes.bridge.foxglove.server import FoxgloveServer


class Listener(ServerListener):
    """
    The SDK's callbacks; they come in its threads.

    :param commands: what clients publish goes there; None where they only read.
    """

    def __init__(self, server: FoxgloveServer, commands: Commands | None) -> None:
        self._server, self._commands = server, commands
        self._schedule = server.schedule

    def on_subscribe(self, client: Any, channel: Any) -> None:
        """Read the topic."""
        self._schedule(partial(self._server.subscribe, channel.topic, client.id))

    def on_unsubscribe(self, client: Any, channel: Any) -> None:
        """Read the topic no more."""
        self._schedule(partial(self._server.unsubscribe, channel.topic, client.id))

    def on_get_parameters(self, client: Any, param_names: list[str],
                          request_id: str | None = None) -> list[Any]:
        """Return parameters."""
        return self._server.read_parameters(param_names)

    def on_set_parameters(self, client: Any, parameters: list[Any],
                          request_id: str | None = None) -> list[Any]:
        """Set parameters, or return them unchanged."""
        return self._server.set_parameters(parameters)

    def on_parameters_subscribe(self, param_names: list[str]) -> None:
        """Follow parameters."""
        self._schedule(partial(self._server.parameters.follow, param_names))

    def on_parameters_unsubscribe(self, param_names: list[str]) -> None:
        """Follow parameters no more."""
        self._schedule(partial(self._server.parameters.forget, param_names))

    def on_connection_graph_subscribe(self) -> None:
        """Publish the graph."""
        self._schedule(partial(self._server.show_graph, True))

    def on_connection_graph_unsubscribe(self) -> None:
        """Publish it no more."""
        self._schedule(partial(self._server.show_graph, False))

    def on_client_advertise(self, client: Any, channel: Any) -> None:
        """Make a publisher."""
        if self._commands is not None:
            self._schedule(partial(self._commands.advertise, (client.id, channel.id),
                                   channel.topic, channel.schema_name, channel.encoding))

    def on_client_unadvertise(self, client: Any, client_channel_id: int) -> None:
        """Take a publisher away."""
        if self._commands is not None:
            self._schedule(partial(self._commands.unadvertise, (client.id, client_channel_id)))

    def on_message_data(self, client: Any, client_channel_id: int, data: bytes) -> None:
        """Publish."""
        if self._commands is not None:
            self._schedule(partial(self._commands.publish, (client.id, client_channel_id), data))
