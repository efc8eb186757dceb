# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A session of the page: the sections of its panel and its own part of the scene."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
import json
from typing import Any

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from armsim_ros.nodes.serving.json_text import to_json

#: A panel gets no more than so many messages a second.
_PANEL_RATE = 30.0


class Session:
    """
    A browser's tab; it stays the same when the tab is loaded again.

    :param key: the tab's own name for itself.
    :param number: shown to other sessions.
    """

    def __init__(self, key: str, number: int) -> None:
        self.key, self.number = key, number
        self.scene: Any = None
        """viser's client, None while the tab has no scene."""
        self.left_at = 0.0
        """When the last panel closed [s]; only of use where there is none."""
        self.sections: dict[str, Any] = {}
        self._panels: set[_Panel] = set()

    @property
    def present(self) -> bool:
        """Whether a panel is open."""
        return bool(self._panels)

    def show(self, name: str, value: Any) -> None:
        """Show this session a section; what has not changed is not sent again."""
        if name not in self.sections or self.sections[name] != value:
            self.sections[name] = value
            self.send(name, value)

    def send(self, name: str, value: Any) -> None:
        """Put a section on its way to the session's panels."""
        for panel in self._panels:
            panel.put(name, value)

    def note(self, text: str, level: str = 'error') -> None:
        """Show a line below the status, once."""
        self.sections.pop('note', None)
        self.show('note', {'text': text, 'level': level})

    async def talk(self, connection: ServerConnection, shared: Mapping[str, Any],
                   receive: Any) -> None:
        """
        Serve a panel until it closes.

        :param shared: sections shown to all sessions.
        :param receive: gets each message that is a JSON object.
        """
        panel = _Panel(connection)
        for name, value in {**shared, **self.sections}.items():
            panel.put(name, value)
        self._panels.add(panel)
        sender = asyncio.create_task(panel.send_all())
        try:
            async for text in connection:
                message = json.loads(text) if isinstance(text, str) else None
                if not isinstance(message, dict):
                    await connection.close(1003, 'not understood')
                    return
                receive(message)
        except (ValueError, RecursionError):
            await connection.close(1003, 'not understood')
        finally:
            self._panels.discard(panel)
            sender.cancel()
            self.left_at = asyncio.get_running_loop().time()


class _Panel:
    """The channel to a panel: the newest value of each section, and no queue behind it."""

    def __init__(self, connection: ServerConnection) -> None:
        self._connection = connection
        self._waiting: dict[str, Any] = {}
        self._news = asyncio.Event()

    def put(self, name: str, value: Any) -> None:
        self._waiting[name] = value
        self._news.set()

    async def send_all(self) -> None:
        try:
            while True:
                await self._news.wait()
                self._news.clear()
                batch, self._waiting = self._waiting, {}
                await self._connection.send(to_json(batch))
                await asyncio.sleep(1.0 / _PANEL_RATE)
        except ConnectionClosed:
            return
