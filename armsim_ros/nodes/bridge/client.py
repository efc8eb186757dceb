# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A connected client: what it receives, and what ends with it."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Coroutine, Mapping
from typing import Any

from rclpy.serialization import serialize_message

from armsim_ros.nodes.bridge.conversion.aside import aside
from armsim_ros.nodes.bridge.conversion.outgoing import json_values
from armsim_ros.nodes.bridge.frames import Fragments, Part, text_frames
from armsim_ros.nodes.bridge.outbox import Outbox
from armsim_ros.nodes.bridge.refusal import Level


class Client:
    """
    A client as the parts of the bridge see it.

    :param address: where it is.
    :param most_bytes: of what waits for it.
    :param fragment_timeout: [s].
    :param overflow: called where it does not read its answers.
    """

    def __init__(self, address: str, most_bytes: int, fragment_timeout: float,
                 overflow: Callable[[], None]) -> None:
        self.address = address
        self.level = Level.ERROR
        self.is_open = True
        self.outbox = Outbox(most_bytes)
        self.fragments = Fragments(fragment_timeout)
        self._overflow = overflow
        self._tasks: set[asyncio.Task[Any]] = set()

    def send(self, message: dict[str, Any], fragment_size: int = 0) -> None:
        """Send an answer, which is never dropped."""
        if self.is_open:
            self._queue(text_frames(message, fragment_size))

    def answer(self, request: Mapping[str, Any], found: dict[str, Any]) -> None:
        """Send an answer to a request, with the request's id where it has one."""
        key = request.get('id')
        self.send(found if key is None else {**found, 'id': key},
                  request.get('fragment_size') or 0)

    async def answer_with(
        self, request: Mapping[str, Any], found: dict[str, Any], message: Any, *,
        compression: str = 'none', adapt: Callable[[dict[str, Any]], Any] = lambda values: values,
    ) -> None:
        """
        Send an answer whose values are a message; a large one is encoded beside other work.

        :param adapt: changes the values.
        """
        raw, key = serialize_message(message), request.get('id')

        def encode() -> list[Part]:
            values = adapt(json_values(type(message))(raw))
            return text_frames({**found, 'values': values, **({} if key is None else {'id': key})},
                               request.get('fragment_size') or 0, compression)

        self._queue(await aside(len(raw), encode))

    def report(self, level: Level, text: str, key: Any = None) -> None:
        """Send a status message, where the client wants those of this level."""
        if level <= self.level:
            found = {'op': 'status', 'level': level.name.lower(), 'msg': text}
            self.send(found if key is None else {**found, 'id': key})

    def start(self, work: Coroutine[Any, Any, None]) -> None:
        """Do something beside the client's next requests; it ends with the client."""
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _queue(self, frames: list[Part]) -> None:
        if not self.is_open:
            return
        self.outbox.add_answer(frames)
        if self.outbox.overflows:
            self._overflow()

    def close(self) -> None:
        """End what was started for it."""
        self.is_open = False
        for task in self._tasks:
            task.cancel()


Handler = Callable[[Client, dict[str, Any]], Awaitable[None]]
