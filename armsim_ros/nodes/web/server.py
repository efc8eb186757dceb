# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The port of the page: authorization, static files, and the routing of websockets.

viser's server requires no token, so its port is opened through this module: the same
server object, with our checks before its own. Where viser opens its port in another way, the
page refuses to start.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from contextvars import ContextVar
from dataclasses import replace
import gzip
import hmac
from http import HTTPStatus
import ipaddress
import logging
from pathlib import Path
import re
import socket
from typing import Any
from urllib.parse import parse_qs, urlsplit

import rich
import viser
import websockets.asyncio.server as websocket_server
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from armsim_ros.errors import ArmsimError

#: The largest message that is read [bytes]: a mesh that the user adds.
LARGEST_MESSAGE = 24 << 20
#: Websockets at the same time; each session has two.
MOST_CONNECTIONS = 128
#: Limits of a session: burst of messages, then messages per second.
BURST, RATE = 400, 200.0
#: Ports that are tried after the requested port.
NEXT_PORTS = 100
#: Path of the websocket whose scene is being served; set while viser's callbacks run.
SESSION: ContextVar[str] = ContextVar('SESSION', default='')

_ID = re.compile(r'[0-9a-f-]{8,40}')
_FILES = {
    '/': ('index.html', 'text/html; charset=utf-8'),
    '/curves.js': ('curves.js', 'text/javascript; charset=utf-8'),
    '/panel.css': ('panel.css', 'text/css; charset=utf-8'),
    '/panel.js': ('panel.js', 'text/javascript; charset=utf-8'),
    '/parts.js': ('parts.js', 'text/javascript; charset=utf-8'),
    '/plots.js': ('plots.js', 'text/javascript; charset=utf-8'),
}
_STATIC = Path(__file__).with_name('static')

Handler = Callable[[ServerConnection], Awaitable[None]]


class WebServerError(ArmsimError):
    """The page cannot be served at this address."""


class WebServer:
    """
    Opens the port and routes each connection.

    :param host: the address to listen at.
    :param port: the first port that is tried.
    :param token: what a request must bring; '' lets all in, on a loopback address alone.
    :param on_panel: talks to a panel; gets the session's id and the connection.
    :raises WebServerError: no port is free, or the address is not of this machine.
    """

    def __init__(
        self,
        host: str,
        port: int,
        token: str,
        on_panel: Callable[[str, ServerConnection], Awaitable[None]],
    ) -> None:
        if not token and not is_loopback(host):
            raise WebServerError(f"host '{host}' is not this machine alone: a token is needed")
        self.host, self._token, self._on_panel = host, token, on_panel
        self._files = {path: ((_STATIC / name).read_bytes(), kind)
                       for path, (name, kind) in _FILES.items()}
        self._page: bytes | None = None
        self._connections = 0
        self._scene: Handler | None = None
        self._viser_pages: Callable[..., Any] | None = None
        self.port = free_port(host, port)
        rich.get_console().quiet = True
        self.viser = self._open_viser()
        self.port = self.viser.get_port()

    @property
    def address(self) -> str:
        """What a person types into the browser."""
        host = f'[{self.host}]' if ':' in self.host else self.host
        if host in ('0.0.0.0', '[::]'):
            host = socket.gethostname()
        return f'http://{host}:{self.port}' + (f'/?token={self._token}' if self._token else '')

    def close(self) -> None:
        """Close the port and every connection."""
        self.viser.stop()

    def _open_viser(self) -> viser.ViserServer:
        """Start viser's server with our checks in it."""
        usual = websocket_server.serve

        def serve(handler: Handler, host: str, port: int, **options: Any) -> Any:
            self._scene = handler
            self._viser_pages = options.pop('process_request')
            options.update(max_size=LARGEST_MESSAGE, logger=_silent_logger())
            return usual(self._serve, host, port, process_request=self._admit, **options)

        websocket_server.serve = serve  # type: ignore[assignment,misc] # a class, to be called
        try:
            server = viser.ViserServer(host=self.host, port=self.port, verbose=False)
        finally:
            websocket_server.serve = usual  # type: ignore[misc] # as above
        if self._scene is None:
            server.stop()
            raise WebServerError(f'viser {viser.__version__} opens its port in a way that the '
                                 "page does not know; install the version of 'armsim_ros[web]'")
        return server

    def _admit(self, connection: ServerConnection, request: Request) -> Response | None:
        """Answer an HTTP request; None lets a websocket through."""
        url = urlsplit(request.path)
        refusal = self._refusal(request, url.query)
        if refusal is not None:
            return refusal
        first, _, session = url.path.strip('/').partition('/')
        known = bool(_ID.fullmatch(session))
        if request.headers.get('Upgrade', '').lower() == 'websocket':
            if first not in ('scene', 'panel') or not known:
                return _answer(HTTPStatus.NOT_FOUND, 'there is nothing here\n')
            if self._connections >= MOST_CONNECTIONS:
                return _answer(HTTPStatus.SERVICE_UNAVAILABLE, 'too many sessions\n')
            return None
        if first == 'scene' and known:
            return self._scene_page(connection, request)
        if url.path not in self._files:
            return _answer(HTTPStatus.NOT_FOUND, 'there is nothing here\n')
        if self._token and 'token' in parse_qs(url.query):
            return self._remember_token()
        body, kind = self._files[url.path]
        return _answer(HTTPStatus.OK, body, kind)

    def _scene_page(self, connection: ServerConnection, request: Request) -> Response:
        """Return viser's page without its own panel, whose place ours takes."""
        if self._page is None:
            assert self._viser_pages is not None
            theirs = self._viser_pages(connection, replace(request, path='/', headers=Headers()))
            style = (_STATIC / 'scene.css').read_bytes()
            text = theirs.body.replace(b'</head>', b'<style>' + style + b'</style></head>', 1)
            self._page = gzip.compress(text)
        response = _answer(HTTPStatus.OK, self._page, 'text/html; charset=utf-8')
        response.headers['Content-Encoding'] = 'gzip'
        return response

    def _refusal(self, request: Request, query: str) -> Response | None:
        """Return why a request may not come in, None where it may."""
        host = request.headers.get('Host', '')
        name = urlsplit(f'//{host}').hostname or ''
        if is_loopback(self.host) and not is_loopback(name):
            # A name that another site has pointed at this machine.
            return _answer(HTTPStatus.FORBIDDEN, 'this page is served to its own machine only\n')
        origin = request.headers.get('Origin')
        if origin is not None and urlsplit(origin).netloc != host:
            return _answer(HTTPStatus.FORBIDDEN, 'this page talks to itself only\n')
        if self._token:
            given = parse_qs(query).get('token', []) + _cookies(request, self._cookie)
            if not any(hmac.compare_digest(word.encode(), self._token.encode())
                       for word in given):
                return _answer(HTTPStatus.UNAUTHORIZED, 'a token is needed: open the address '
                               "that the program printed, with '?token=...'\n")
        return None

    @property
    def _cookie(self) -> str:
        return f'armsim_token_{self.port}'

    def _remember_token(self) -> Response:
        """Put the token into a cookie and take it out of the address."""
        response = _answer(HTTPStatus.FOUND, '')
        response.headers['Location'] = '/'
        response.headers['Set-Cookie'] = (
            f'{self._cookie}={self._token}; HttpOnly; SameSite=Strict; Path=/')
        return response

    async def _serve(self, connection: ServerConnection) -> None:
        """Serve a websocket until it closes; nothing that it sends ends more than itself."""
        assert connection.request is not None
        first, _, session = urlsplit(connection.request.path).path.strip('/').partition('/')
        _limit_rate(connection)
        self._connections += 1
        try:
            if first == 'panel':
                await self._on_panel(session, connection)
            else:
                assert self._scene is not None
                SESSION.set(session)
                await self._scene(connection)
        except ConnectionClosed:
            pass
        except Exception:  # noqa: BLE001 - whatever was sent, it was not understood
            await connection.close(1003, 'not understood')
        finally:
            self._connections -= 1


def is_loopback(host: str) -> bool:
    """Return whether an address is reached from this machine alone."""
    if host == 'localhost':
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def free_port(host: str, first: int) -> int:
    """
    Return the first port from the requested port on that is not in use; 0 stays 0.

    :raises WebServerError: none is free, or the address is not of this machine.
    """
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(
            host, None, type=socket.SOCK_STREAM)[0]
    except OSError as error:
        raise WebServerError(f"host '{host}' is not known: {error.strerror}") from None
    trouble: OSError | None = None
    for port in range(first, min(first + NEXT_PORTS, 65536)):
        with socket.socket(family, kind, protocol) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((address[0], port))
                probe.listen(1)
            except OSError as error:
                trouble = error
                continue
            return port
    reason = trouble.strerror if trouble else 'there is no such port'
    raise WebServerError(f'no port from {first} on can be opened at {host}: {reason}')


def _limit_rate(connection: ServerConnection) -> None:
    """Read no more than so many messages a second; what comes quicker waits at its sender."""
    receive, loop = connection.recv, asyncio.get_running_loop()
    left, since = float(BURST), loop.time()

    async def limited(*words: Any, **options: Any) -> Any:
        nonlocal left, since
        now = loop.time()
        left, since = min(BURST, left + RATE * (now - since)) - 1.0, now
        if left < 0.0:
            await asyncio.sleep(-left / RATE)
        return await receive(*words, **options)

    connection.recv = limited  # type: ignore[method-assign] # of this object


def _cookies(request: Request, name: str) -> list[str]:
    pairs = [pair.strip().partition('=') for header in request.headers.get_all('Cookie')
             for pair in header.split(';')]
    return [value for key, _, value in pairs if key == name]


def _answer(status: HTTPStatus, body: str | bytes, kind: str = 'text/plain; charset=utf-8'
            ) -> Response:
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


def _silent_logger() -> logging.Logger:
    """Return a logger for what strangers send; none of it is for the terminal."""
    logger = logging.getLogger(f'{__name__}.connections')
    logger.propagate = False
    logger.disabled = True
    return logger
