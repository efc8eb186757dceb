# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which requests a server answers, how fast it reads, and a gate for a server without rules."""

from __future__ import annotations

import asyncio
from collections.abc import Collection
from contextlib import suppress
from dataclasses import dataclass
import hmac
from http import HTTPStatus
import ssl
from urllib.parse import parse_qs, urlsplit

from websockets.datastructures import Headers
from websockets.exceptions import WebSocketException
from websockets.http11 import Request, Response
from websockets.streams import StreamReader as Bytes

from armsim_ros.nodes.ports import free_port, is_loopback


class RateLimit:
    """
    A bucket that fills with time and empties with use.

    :param burst: units that may come at once.
    :param rate: units per second after that.
    """

    def __init__(self, burst: float, rate: float) -> None:
        self._burst, self._rate = burst, rate
        self._left, self._since = burst, 0.0

    def delay(self, now: float, amount: float = 1.0) -> float:
        """
        Count what has come and return how long to wait before reading on.

        :param now: [s], of any clock.
        :param amount: units.
        :returns: [s], 0 where the limit is kept.
        """
        filled = self._left + self._rate * max(0.0, now - self._since)
        self._left, self._since = min(self._burst, filled) - amount, now
        return max(0.0, -self._left / self._rate)


@dataclass(frozen=True)
class AccessRules:
    """
    The rules of a server at an address.

    A loopback address answers only requests for a loopback name, so that no other site can point
    its own name at this machine (DNS rebinding). Elsewhere the token protects against that.

    :param host: the address that the server is bound to.
    :param token: what each request must bring; '' admits requests without a token.
    :param cookie: name of a cookie that may bring the token, '' for none.
    :param origins: pages of other sites that may connect, such as ``https://a.example``; their
        names are also accepted as Host.
    :param local_pages: whether pages of any port of this machine may connect.
    :param host_refusal: the answer to a request for a foreign name.
    :param origin_refusal: the answer to a foreign page, which it names as ``{origin}``.
    :param token_refusal: the answer to a request without the token.
    """

    host: str
    token: str
    host_refusal: str
    origin_refusal: str
    token_refusal: str
    cookie: str = ''
    origins: Collection[str] = ()
    local_pages: bool = False

    def refusal(self, request: Request) -> Response | None:
        """Return why a request is not answered, None where it is."""
        host = request.headers.get('Host', '')
        if is_loopback(self.host) and not self._is_own_name(_name_of(f'//{host}')):
            return answer(HTTPStatus.FORBIDDEN, self.host_refusal)
        origin = request.headers.get('Origin')
        if origin is not None and not self._admits_page(origin, host):
            shown = ''.join(filter(str.isprintable, origin))[:200]
            return answer(HTTPStatus.FORBIDDEN, self.origin_refusal.format(origin=shown))
        if self.token and not any(
                hmac.compare_digest(given.encode('utf-8', 'replace'), self.token.encode())
                for given in self._given_tokens(request)):
            return answer(HTTPStatus.UNAUTHORIZED, self.token_refusal)
        return None

    def _is_own_name(self, name: str) -> bool:
        return is_loopback(name) or name == self.host or (name != '' and any(
            name == _name_of(origin) for origin in self.origins))

    def _admits_page(self, origin: str, host: str) -> bool:
        if origin in self.origins:
            return True
        try:
            parts = urlsplit(origin)
        except ValueError:
            return False
        if parts.netloc and parts.netloc == host:
            return True
        return self.local_pages and parts.scheme in ('http', 'https') and is_loopback(
            _name_of(origin))

    def _given_tokens(self, request: Request) -> list[str]:
        try:
            given = parse_qs(urlsplit(request.path).query).get('token', [])
        except ValueError:
            given = []
        for header in request.headers.get_all('Authorization'):
            kind, _, value = header.partition(' ')
            if kind.lower() == 'bearer':
                given.append(value.strip())
        if self.cookie:
            pairs = [pair.strip().partition('=') for header in request.headers.get_all('Cookie')
                     for pair in header.split(';')]
            given += [value for key, _, value in pairs if key == self.cookie]
        return given


def answer(status: HTTPStatus, body: str | bytes, kind: str = 'text/plain; charset=utf-8'
           ) -> Response:
    """Return a complete HTTP response that ends the connection."""
    data = body.encode() if isinstance(body, str) else body
    return Response(status.value, status.phrase, Headers({
        'Content-Type': kind,
        'Content-Length': str(len(data)),
        'Cache-Control': 'no-cache',
        'Referrer-Policy': 'no-referrer',
        'X-Content-Type-Options': 'nosniff',
        'X-Frame-Options': 'SAMEORIGIN',
        'Connection': 'close',
    }), data)


def _name_of(url: str) -> str:
    """Return the host of an address without its port, '' where there is none."""
    try:
        return urlsplit(url).hostname or ''
    except ValueError:
        return ''


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

    @property
    def connections(self) -> int:
        """How many connections are open."""
        return self._open

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
