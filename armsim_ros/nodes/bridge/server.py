# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The port of rosbridge: access rules, limits, and the connections."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable, Sequence
from contextlib import suppress
import ctypes
import gc
from http import HTTPStatus
import ssl
from urllib.parse import urlsplit

from websockets.asyncio.server import serve, Server, ServerConnection
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.protocol import State

from armsim_ros.nodes.access import AccessRules, answer, HANDSHAKE, MOST_HANDSHAKES, RateLimit
from armsim_ros.nodes.bridge.client import Client
from armsim_ros.nodes.bridge.frames import Part
from armsim_ros.nodes.bridge.interfaces import Level
from armsim_ros.nodes.bridge.settings import BridgeSettings
from armsim_ros.nodes.ports import free_port, ServingError, shown_host, silent_logger

#: What a client may send: messages and bytes per second; a burst is a second's worth.
MESSAGE_RATE, BYTE_RATE = 5000.0, 20.0 * (1 << 20)
#: Frames of a client that are read ahead.
_READ_AHEAD = 4
#: Clients of which a frame is served, and to which one is sent, in each pass of the event loop.
_LEAST_READ, _LEAST_SENT = 4, 32
#: How long frames are served in a pass of the event loop [s].
_SLICE = 0.002
#: What is read of a connection in a pass of the event loop [bytes].
_READ_SIZE = 1 << 13
#: What is written at once, and buffered before the client has to take it [bytes].
_WRITE_LIMIT = 1 << 16
_OVERFLOW = 1013
#: After the last client that has left, memory is returned once no other leaves for so long [s].
_QUIET = 2.0


class Turns:
    """
    Limits what is served between two passes of the event loop, whatever number of clients waits.

    :param least: number of clients that are served in a pass, however long that takes.
    """

    def __init__(self, least: int) -> None:
        self._least = least
        self._waiting: deque[asyncio.Future[None]] = deque()
        self._end = 0.0

    async def take(self) -> None:
        """Wait until a frame may be served."""
        loop = asyncio.get_running_loop()
        if loop.time() < self._end:
            return
        if not self._waiting:
            loop.call_soon(self._next)
        turn = loop.create_future()
        self._waiting.append(turn)
        await turn

    def _next(self) -> None:
        loop = asyncio.get_running_loop()
        self._end = loop.time() + _SLICE
        for _ in range(min(self._least, len(self._waiting))):
            turn = self._waiting.popleft()
            if not turn.done():
                turn.set_result(None)
        if self._waiting:
            loop.call_soon(self._next)


class _Connection(ServerConnection):
    """
    A connection that counts while its handshake lasts; too many are closed unread.

    Frames are made once for all clients, so they go past ``send``, which would make each anew.
    """

    pending: set[ServerConnection]
    _is_writing = False

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        if len(self.pending) >= MOST_HANDSHAKES and isinstance(transport, asyncio.Transport):
            transport.abort()
        self.pending.add(self)
        # asyncio's own size holds thousands of short frames, which are parsed at once.
        transport.max_size = _READ_SIZE  # type: ignore[attr-defined] # of its socket transports
        super().connection_made(transport)

    def connection_lost(self, exc: Exception | None) -> None:
        self.pending.discard(self)
        super().connection_lost(exc)

    async def write(self, frames: Sequence[Part], turns: Turns) -> None:
        """
        Write the parts of frames, in pieces where they are large, as the client takes them.

        :param turns: who is served next.
        """
        self._is_writing = True
        pieces = (memoryview(part)[start:start + _WRITE_LIMIT] for part in frames
                  for start in range(0, len(part), _WRITE_LIMIT))
        for index, piece in enumerate(pieces):
            if index:
                await turns.take()
            if self.transport.is_closing():
                return
            self.transport.write(piece)
            if self.paused:
                with suppress(OSError):  # the connection is lost
                    await self.drain()
        self._is_writing = False
        self.send_data()

    def send_data(self) -> None:
        """Send what the protocol has queued, but not within a frame."""
        if not self._is_writing:
            super().send_data()


class BridgeServer:
    """
    Accepts clients and moves their frames.

    :param token: what a client must bring; '' admits all.
    :param receive: serves a frame of a client.
    :param change: called with each client that came or is about to go.
    :param drop: ends what a client has left.
    :param get: answers a GET of a path that is not the websocket's; None where it has nothing.
    """

    def __init__(
        self, settings: BridgeSettings, token: str,
        receive: Callable[[Client, str | bytes], Awaitable[None]],
        change: Callable[[], None], drop: Callable[[Client], Awaitable[None]],
        get: Callable[[str, Request], Awaitable[Response | None]],
    ) -> None:
        self._settings, self._token = settings, token
        self._receive, self._change, self._drop, self._get = receive, change, drop, get
        self.clients: dict[Client, ServerConnection] = {}
        self.port = settings.port
        self._server: Server | None = None
        self._admitted = 0
        self._tidying: asyncio.TimerHandle | None = None
        self._reading, self._sending = Turns(_LEAST_READ), Turns(_LEAST_SENT)
        self._rules = bridge_rules(settings, token, settings.port, settings.url_path)

    @property
    def url(self) -> str:
        """What a client connects to."""
        return bridge_url(self._settings, self._token, self.port, self._settings.url_path)

    async def open(self) -> None:
        """
        Open the port.

        :raises ServingError: it is taken, or the certificate cannot be read.
        """
        settings = self._settings
        try:
            free_port(settings.address, settings.port, 1)
        except ServingError as error:
            raise ServingError(f'{error}; port:=0 takes any free port') from None
        kind = type('Connection', (_Connection,), {'pending': set()})
        self._server = await serve(
            self._serve, settings.address, settings.port, process_request=self._admit,
            compression=None, max_size=settings.max_message_size, max_queue=_READ_AHEAD,
            open_timeout=HANDSHAKE, close_timeout=1.0, write_limit=_WRITE_LIMIT,
            ping_interval=settings.websocket_ping_interval or None,
            ping_timeout=settings.websocket_ping_timeout or None,
            logger=silent_logger(__name__), server_header=None, create_connection=kind,
            ssl=tls(settings))
        self.port = next(iter(self._server.sockets)).getsockname()[1]

    async def close(self) -> None:
        """Close all connections and the port."""
        if self._server is not None:
            self._server.close()
            await self._server.wait_closed()
        if self._tidying is not None:
            self._tidying.cancel()

    async def _admit(self, connection: ServerConnection, request: Request) -> Response | None:
        """Answer an HTTP request; None lets a websocket through."""
        refusal = self._rules.refusal(request)
        if refusal is not None:
            return refusal
        try:
            path = urlsplit(request.path).path
        except ValueError:
            return answer(HTTPStatus.BAD_REQUEST, 'the address cannot be read\n')
        if request.headers.get('Upgrade', '').lower() != 'websocket':
            found = await self._get(path, request)
            return found if found is not None else answer(
                HTTPStatus.UPGRADE_REQUIRED, 'this is rosbridge v2, for websockets: '
                f'{_scheme(self._settings)}://HOST:{self.port}{self._settings.url_path}; the page '
                'of armsim is served by web:=true\n')
        if path.rstrip('/') != self._settings.url_path.rstrip('/'):
            return answer(HTTPStatus.NOT_FOUND,
                          f'the websocket is at {self._settings.url_path}\n')
        if len(self.clients) + self._admitted >= self._settings.max_clients:
            return answer(
                HTTPStatus.SERVICE_UNAVAILABLE,
                f'{self._settings.max_clients} clients are connected (max_clients)\n')
        self._admitted += 1
        asyncio.get_running_loop().call_soon(self._forget_admission)
        return None

    def _forget_admission(self) -> None:
        self._admitted -= 1

    async def _serve(self, connection: ServerConnection) -> None:
        assert isinstance(connection, _Connection)  # create_connection of the port
        connection.pending.discard(connection)
        loop = asyncio.get_running_loop()
        address = connection.remote_address
        closing: list[asyncio.Task[None]] = []

        def overflow() -> None:
            closing.append(loop.create_task(connection.close(_OVERFLOW, 'answers are not read')))

        client = Client(
            address[0] if address else '', self._settings.max_client_backlog,
            self._settings.fragment_timeout,
            overflow)
        self.clients[client] = connection
        self._change()
        sender = loop.create_task(self._send_all(client, connection))
        try:
            await self._read_all(client, connection)
        except ConnectionClosed:
            pass
        finally:
            client.is_open = False
            sender.cancel()
            del self.clients[client]
            self._change()
            await self._drop(client)
            if self._tidying is not None:
                self._tidying.cancel()
            self._tidying = loop.call_later(
                _QUIET, loop.run_in_executor, None, _give_back)

    async def _send_all(self, client: Client, connection: _Connection) -> None:
        """Write what the outbox gives, as the client takes it; busy clients take turns."""
        while connection.state is State.OPEN:
            await client.outbox.wait()
            await self._sending.take()
            try:
                frames = await client.outbox.take()
            except Exception as error:  # noqa: BLE001 - the next message may be sent
                client.report(
                    Level.ERROR, f'a message was not sent: {type(error).__name__}: {error}')
                continue
            if connection.state is State.OPEN:
                await connection.write(frames, self._sending)

    async def _read_all(self, client: Client, connection: ServerConnection) -> None:
        clock = asyncio.get_running_loop().time
        messages = RateLimit(MESSAGE_RATE, MESSAGE_RATE)
        sizes = RateLimit(BYTE_RATE, BYTE_RATE)
        while True:
            frame = await connection.recv()
            now = clock()
            delay = max(messages.delay(now), sizes.delay(now, len(frame)))
            if delay:
                await asyncio.sleep(delay)
            await self._reading.take()
            await self._receive(client, frame)


def _give_back() -> None:
    """Return memory that is not used to the system; glibc keeps what was freed."""
    gc.collect()
    trim = getattr(ctypes.CDLL(None), 'malloc_trim', None)
    if trim is not None:
        trim(0)


def bridge_rules(settings: BridgeSettings, token: str, port: int, path: str = '/',
                 origins: Sequence[str] = ()) -> AccessRules:
    """
    Return the rules of a port of the bridge.

    :param token: what a client must bring; '' admits all.
    :param origins: pages that may connect besides those of the settings.
    """
    return AccessRules(
        settings.address, token, origins=(*settings.origins, *origins), local_pages=True,
        host_refusal='this bridge serves its own machine; for another name start it with '
                     'origins:=http://NAME\n',
        origin_refusal='a page of {origin} may not use this bridge; start it with '
                       'origins:={origin}\n',
        token_refusal=f'a token is needed: {_scheme(settings)}://HOST:{port}{path}?token=...\n')


def bridge_url(settings: BridgeSettings, token: str, port: int, path: str = '/') -> str:
    """Return what a client of a port connects to."""
    shown = f'{path}?token={token}' if token else '' if path == '/' else path
    return f'{_scheme(settings)}://{shown_host(settings.address)}:{port}{shown}'


def _scheme(settings: BridgeSettings) -> str:
    return 'wss' if settings.certfile else 'ws'


def tls(settings: BridgeSettings) -> ssl.SSLContext | None:
    """
    Return the context of the certificate, None where there is none.

    :raises ServingError: it cannot be read.
    """
    if not settings.certfile:
        return None
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    try:
        context.load_cert_chain(settings.certfile, settings.keyfile)
    except (OSError, ssl.SSLError) as error:
        raise ServingError(f'certfile {settings.certfile}, keyfile {settings.keyfile}: {error}'
                           ) from None
    return context
