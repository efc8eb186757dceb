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
from http import HTTPStatus
from pathlib import Path
import re
from typing import Any
from urllib.parse import parse_qs, urlsplit

import rich
import viser
import websockets.asyncio.server as websocket_server
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from armsim_ros.nodes.access import AccessRules, answer, RateLimit
from armsim_ros.nodes.ports import free_port, is_loopback, ServingError, shown_host, silent_logger

#: The largest message that is read [bytes]: a mesh that the user adds.
LARGEST_MESSAGE = 24 << 20
#: Websockets at the same time; each session has two.
MOST_CONNECTIONS = 128
#: Limits of a session: burst of messages, then messages per second.
BURST, RATE = 400, 200.0
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


class WebServerError(ServingError):
    """The page cannot be served at this address."""


class WebServer:
    """
    Opens the port and routes each connection.

    :param host: the address to listen at.
    :param port: the first port that is tried.
    :param token: what a request must bring; '' lets all in, on a loopback address alone.
    :param on_panel: talks to a panel; gets the session's id and the connection.
    :raises ServingError: no port is free, or the address is not of this machine.
    """

    def __init__(
        self, host: str, port: int, token: str,
        on_panel: Callable[[str, ServerConnection], Awaitable[None]]
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
        address = f'http://{shown_host(self.host)}:{self.port}'
        return address + (f'/?token={self._token}' if self._token else '')

    def close(self) -> None:
        """Close the port and every connection."""
        self.viser.stop()

    def _open_viser(self) -> viser.ViserServer:
        """Start viser's server with our checks in it."""
        usual = websocket_server.serve

        def serve(handler: Handler, host: str, port: int, **options: Any) -> Any:
            self._scene = handler
            self._viser_pages = options.pop('process_request')
            options.update(max_size=LARGEST_MESSAGE, logger=silent_logger(__name__))
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
        refusal = self._rules.refusal(request)
        if refusal is not None:
            return refusal
        first, _, session = url.path.strip('/').partition('/')
        known = bool(_ID.fullmatch(session))
        if request.headers.get('Upgrade', '').lower() == 'websocket':
            if first not in ('scene', 'panel') or not known:
                return answer(HTTPStatus.NOT_FOUND, 'there is nothing here\n')
            if self._connections >= MOST_CONNECTIONS:
                return answer(HTTPStatus.SERVICE_UNAVAILABLE, 'too many sessions\n')
            return None
        if first == 'scene' and known:
            return self._scene_page(connection, request)
        if url.path not in self._files:
            return answer(HTTPStatus.NOT_FOUND, 'there is nothing here\n')
        if self._token and 'token' in parse_qs(url.query):
            return self._remember_token()
        body, kind = self._files[url.path]
        return answer(HTTPStatus.OK, body, kind)

    def _scene_page(self, connection: ServerConnection, request: Request) -> Response:
        """Return viser's page without its own panel, whose place ours takes."""
        if self._page is None:
            assert self._viser_pages is not None
            theirs = self._viser_pages(connection, replace(request, path='/', headers=Headers()))
            style = (_STATIC / 'scene.css').read_bytes()
            text = theirs.body.replace(b'</head>', b'<style>' + style + b'</style></head>', 1)
            self._page = gzip.compress(text)
        response = answer(HTTPStatus.OK, self._page, 'text/html; charset=utf-8')
        response.headers['Content-Encoding'] = 'gzip'
        return response

    @property
    def _rules(self) -> AccessRules:
        return AccessRules(
            self.host, self._token, cookie=self._cookie,
            host_refusal='this page is served to its own machine only\n',
            origin_refusal='this page talks to itself only\n',
            token_refusal="a token is needed: open the address that the program printed, with "
                          "'?token=...'\n")

    @property
    def _cookie(self) -> str:
        return f'armsim_token_{self.port}'

    def _remember_token(self) -> Response:
        """Put the token into a cookie and take it out of the address."""
        response = answer(HTTPStatus.FOUND, '')
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


def _limit_rate(connection: ServerConnection) -> None:
    """Read no more than so many messages a second; what comes quicker waits at its sender."""
    receive, loop = connection.recv, asyncio.get_running_loop()
    limit = RateLimit(BURST, RATE)

    async def limited(*words: Any, **options: Any) -> Any:
        delay = limit.delay(loop.time())
        if delay:
            await asyncio.sleep(delay)
        return await receive(*words, **options)

    connection.recv = limited  # type: ignore[method-assign] # of this object
