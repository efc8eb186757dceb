# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Access rules for a websocket server that has none of its own."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from http import HTTPStatus
import ssl

from websockets.exceptions import WebSocketException
from websockets.http11 import Request, Response
from websockets.streams import StreamReader as Bytes

from armsim_ros.nodes.serving.access import AccessRules, answer
from armsim_ros.nodes.serving.ports import free_port

#: Handshakes at the same time, and how long one may take [s].
MOST_HANDSHAKES, HANDSHAKE = 30, 5.0
#: Of the head of a request [bytes].
_MOST = 1 << 14
_CHUNK = 1 << 16
_END = b'\r\n\r\n'


class Gate:
    """
    A port that checks each request, and passes on the connections that it admits.

    :param rules: of the port.
    :param target: address and port of the server behind it.
    :param most: connections at the same time.
    """

    def __init__(self, rules: AccessRules, target: tuple[str, int], most: int) -> None:
        self._rules, self._target, self._most = rules, target, most
        self._open = self._pending = 0
        self._server: asyncio.Server | None = None
        self._tasks: set[asyncio.Task[None]] = set()

    async def open(self, address: str, port: int, context: ssl.SSLContext | None) -> int:
        """
        Open the port and return its number.

        :param port: 0 for any that is free.
        :raises ServingError: it is taken.
        """
        free_port(address, port, 1)
        self._server = await asyncio.start_server(
            self._serve, address, port, limit=_MOST, ssl=context)
        found: int = self._server.sockets[0].getsockname()[1]
        return found

    def close(self) -> None:
        """Close the port and all connections."""
        if self._server is not None:
            self._server.close()
        for task in self._tasks:
            task.cancel()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.current_task()
        assert task is not None  # start_server makes one per connection
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        try:
            if self._pending >= MOST_HANDSHAKES:
                return
            self._pending += 1
            try:
                head = await asyncio.wait_for(reader.readuntil(_END), HANDSHAKE)
            finally:
                self._pending -= 1
            refusal = self._refusal(head)
            if refusal is not None:
                writer.write(refusal.serialize())
                return
            self._open += 1
            try:
                await self._pass_on(head, reader, writer)
            finally:
                self._open -= 1
        except (OSError, EOFError, asyncio.LimitOverrunError, asyncio.TimeoutError, TimeoutError,
                ValueError, LookupError, WebSocketException, asyncio.CancelledError):
            return  # not HTTP, or the connection or the program has ended
        finally:
            writer.close()

    def _refusal(self, head: bytes) -> Response | None:
        """Return why a request is not passed on, None where it is."""
        content = Bytes()
        content.feed_data(head)
        parsing = Request.parse(content.read_line)
        try:
            next(parsing)
        except StopIteration as end:
            request: Request = end.value
        else:
            raise ValueError('the head of the request is incomplete')
        refusal = self._rules.refusal(request)
        if refusal is None and request.headers.get('Upgrade', '').lower() != 'websocket':
            return answer(HTTPStatus.UPGRADE_REQUIRED, 'this port is for websockets\n')
        if refusal is None and self._open >= self._most:
            return answer(HTTPStatus.SERVICE_UNAVAILABLE,
                          f'{self._most} clients are connected (max_clients)\n')
        return refusal

    async def _pass_on(self, head: bytes, reader: asyncio.StreamReader,
                       writer: asyncio.StreamWriter) -> None:
        """Move bytes both ways until either end closes."""
        target_reader, target_writer = await asyncio.open_connection(*self._target)
        target_writer.write(head)
        ways = [asyncio.ensure_future(_copy(*way)) for way in (
            (reader, target_writer), (target_reader, writer))]
        try:
            await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for way in ways:
                way.cancel()
            target_writer.close()


async def _copy(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    with suppress(OSError):
        while data := await reader.read(_CHUNK):
            writer.write(data)
            await writer.drain()
