# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Who may come in: a real server, and clients that do not behave."""

import asyncio
import contextlib
import http.client
import socket

import pytest

pytest.importorskip('viser')

import websockets.asyncio.client as websocket_client
from websockets.exceptions import InvalidStatus

from armsim_ros.nodes.ports import free_port, ServingError
from armsim_ros.nodes.web.server import LARGEST_MESSAGE, WebServer

KEY = '0123456789abcdef'


async def echo(_visitor, connection):
    """Send back what comes."""
    async for text in connection:
        await connection.send(text)


@pytest.fixture(params=['', 'secret'], ids=['open', 'with a token'])
def token(request):
    """Return the token that the server asks for."""
    return request.param


@pytest.fixture
def server(token):
    """Open a server on this machine."""
    opened = WebServer('127.0.0.1', 8400, token, echo)
    yield opened
    opened.close()


def get(server, path, **headers):
    """Return status, headers and body of a GET."""
    connection = http.client.HTTPConnection('127.0.0.1', server.port, timeout=10)
    connection.request('GET', path, headers=headers)
    answer = connection.getresponse()
    found = answer.status, dict(answer.getheaders()), answer.read()
    connection.close()
    return found


def talk(server, path, messages=('hello',), **headers):
    """Open a websocket, send messages, return the last answer."""
    async def run():
        async with websocket_client.connect(
                f'ws://127.0.0.1:{server.port}{path}', additional_headers=headers,
                subprotocols=['viser-v0'], open_timeout=10, max_size=None) as connection:
            for message in messages:
                await connection.send(message)
            return await asyncio.wait_for(connection.recv(), 10)

    return asyncio.run(run())


def test_the_token_opens_page_scene_and_websocket_and_nothing_else_does(server, token):
    """Refused without it, with a wrong one, and by cookie let in."""
    if not token:
        pytest.skip('this server asks for none')
    for path in ('/', '/panel.js', f'/scene/{KEY}'):
        assert get(server, path)[0] == 401
        assert get(server, f'{path}?token=wrong')[0] == 401
    for path in (f'/panel/{KEY}', f'/scene/{KEY}'):
        with pytest.raises(InvalidStatus) as refusal:
            talk(server, path)
        assert refusal.value.response.status_code == 401
    status, headers, _ = get(server, '/?token=secret')
    assert (status, headers['Location']) == (302, '/')
    cookie = headers['Set-Cookie'].partition(';')[0]
    assert 'HttpOnly' in headers['Set-Cookie']
    assert get(server, '/', Cookie=cookie)[0] == 200
    assert talk(server, f'/panel/{KEY}', Cookie=cookie) == 'hello'


def test_nothing_is_handed_out_but_the_page(server, token):
    """No path leads to another file."""
    allowed = {'Cookie': f'armsim_token_{server.port}={token}'}
    assert b'Plan &amp; Execute' in get(server, '/', **allowed)[2]
    for path in ('/../server.py', '/server.py', '/%2e%2e/server.py', '/static/index.html',
                 '/etc/passwd', '//etc/passwd', f'/scene/{KEY}/../../etc/passwd', '/scene/x'):
        assert get(server, path, **allowed)[0] == 404, path


def test_another_site_cannot_use_the_users_browser(server, token):
    """Neither by its own origin, nor by a name that points at this machine."""
    allowed = {'Cookie': f'armsim_token_{server.port}={token}'}
    assert get(server, '/', Host='evil.example', **allowed)[0] == 403
    assert get(server, '/', Origin='http://evil.example', **allowed)[0] == 403
    with pytest.raises(InvalidStatus):
        talk(server, f'/panel/{KEY}', Origin='http://evil.example', **allowed)


@pytest.mark.parametrize('path', ['panel', 'scene'])
@pytest.mark.parametrize('message', [
    'garbage', b'\xff' * 1000, b'', '{', b'x' * (LARGEST_MESSAGE + 1)],
    ids=['text', 'bytes', 'nothing', 'half of an object', 'too large'])
def test_garbage_closes_its_own_connection_at_most(server, token, path, message):
    """The next visitor is served as before."""
    allowed = {'Cookie': f'armsim_token_{server.port}={token}'}
    with contextlib.suppress(Exception):  # whatever becomes of the one that misbehaves
        talk(server, f'/{path}/{KEY}', [message], **allowed)
    assert talk(server, f'/panel/{KEY}', **allowed) == 'hello'


def test_bytes_that_are_no_http_end_nothing(server, token):
    """A port scanner, for one."""
    with socket.create_connection(('127.0.0.1', server.port), timeout=10) as plug:
        plug.sendall(b'\x00\x01\x02' * 1000 + b'\r\n\r\n')
        plug.recv(100)
    allowed = {'Cookie': f'armsim_token_{server.port}={token}'}
    assert get(server, '/', **allowed)[0] == 200


def test_an_address_of_others_needs_a_token():
    """Nobody can forget it."""
    with pytest.raises(ServingError, match='a token is needed'):
        WebServer('0.0.0.0', 8400, '', echo)


def test_a_port_that_is_taken_is_passed_over():
    """The next free one is found; an address of another machine is not."""
    with socket.create_server(('127.0.0.1', 0)) as taken:
        port = taken.getsockname()[1]
        assert free_port('127.0.0.1', port) > port
    with pytest.raises(ServingError, match=r'192\.0\.2\.1'):
        free_port('192.0.2.1', 8400)
