# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The port before a server that checks nothing itself."""

import asyncio
import contextlib

import pytest

pytest.importorskip('websockets')

from armsim_ros.nodes.access import AccessRules, Gate

UPGRADE = 'Upgrade: websocket\r\nConnection: Upgrade\r\n'


def responses(*requests, most=32, keep=False):
    """Return what each request gets, and how many connections reached the server behind."""
    async def run():
        reached, open_ends = [], []

        async def serve(reader, writer):
            reached.append(await reader.readuntil(b'\r\n\r\n'))
            writer.write(b'passed on, ' + await reader.read(5))
            open_ends.append(writer)
            if not keep:
                writer.close()

        server = await asyncio.start_server(serve, '127.0.0.1', 0)
        gate = Gate(AccessRules('127.0.0.1', 'word', 'host', 'origin', 'token'),
                    server.sockets[0].getsockname(), most)
        port = await gate.open('127.0.0.1', 0, None)
        answers = []
        for request in requests:
            reader, writer = await asyncio.open_connection('127.0.0.1', port)
            open_ends.append(writer)
            writer.write(request.encode() + b'\r\nhello')
            answers.append(await reader.read(1 if keep else -1))
        gate.close()
        server.close()
        for writer in open_ends:
            writer.close()
            with contextlib.suppress(OSError):
                await writer.wait_closed()
        return answers, reached

    return asyncio.run(run())


@pytest.mark.parametrize(('path', 'headers', 'status'), [
    ('/?token=word', 'Host: evil.example\r\n', b'403'),
    ('/?token=word', 'Host: localhost\r\nOrigin: https://evil.example\r\n', b'403'),
    ('/', 'Host: localhost\r\n', b'401'),
])
def test_what_is_refused_never_reaches_the_server(path, headers, status):
    """By the same rules as of any other port."""
    answers, reached = responses(f'GET {path} HTTP/1.1\r\n{headers}{UPGRADE}')
    assert answers[0].startswith(b'HTTP/1.1 ' + status)
    assert reached == []


def test_what_is_admitted_is_passed_on_unchanged():
    """Both ways; a plain request is told that this is a port for websockets."""
    request = f'GET /?token=word HTTP/1.1\r\nHost: localhost\r\n{UPGRADE}'
    answers, reached = responses(
        request, 'GET /?token=word HTTP/1.1\r\nHost: localhost\r\n', 'nonsense\r\n')
    assert answers[0] == b'passed on, hello'
    assert answers[1].startswith(b'HTTP/1.1 426')
    assert answers[2] == b''
    assert reached == [f'{request}\r\n'.encode()]


def test_connections_are_limited():
    """The next one is refused while they are open."""
    request = f'GET /?token=word HTTP/1.1\r\nHost: localhost\r\n{UPGRADE}'
    _, reached = responses(request, request, request, most=2, keep=True)
    assert len(reached) == 2
