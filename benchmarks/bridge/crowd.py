# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Many clients at once that send what they should not."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import suppress
import json
import random
import socket
import sys
from typing import Any
from urllib.parse import urlsplit

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import WebSocketException

#: Nested too deeply, or never closed.
BOMBS = ('{' * 4000 + '}' * 4000, '[' * 50_000 + ']' * 49_000, '{"a":' * 15_000)
#: The words that random messages are made of.
_WORDS: tuple[Any, ...] = (
    'op', 'topic', 'msg', '/seen', 'publish', 'subscribe', 'id', 'call_service', 'type', 'service',
    '/rosapi/get_time', 'sensor_msgs/JointState', None, True, -1, 1e400, [], {})
_SUBSCRIBE = '{"op": "subscribe", "topic": "/joint_states", "throttle_rate": 500}'
#: Of clients that subscribe to pictures and read none, one in so many; each wants them otherwise.
_IDLE = 10
#: Operations that look for what is not there.
_SEEKING = ('publish', 'subscribe', 'advertise', 'call_service', 'send_action_goal',
            'advertise_service', 'cancel_action_goal')
#: Handshakes at the same time.
_STEP = 20


def random_frames(count: int, seed: int) -> Iterator[str | bytes]:
    """
    Yield frames that are bytes, cut off messages, and values of any shape; then the bombs.

    A few look for topics, services and types that are not there.
    """
    source = random.Random(seed)

    def value(depth: int) -> Any:
        choice = source.random()
        if depth > 3 or choice < 0.5:
            return source.choice(_WORDS)
        if choice < 0.7:
            return [value(depth + 1) for _ in range(source.randrange(4))]
        return {str(source.choice(_WORDS)): value(depth + 1) for _ in range(source.randrange(4))}

    for index in range(count):
        if index % 25 == 1:
            yield json.dumps({'op': source.choice(_SEEKING), 'topic': '/none', 'service': '/none',
                              'action': '/none', 'action_type': 'no/Type', 'id': index})
        elif index % 4 == 0:
            yield source.randbytes(source.randrange(60))
        elif index % 4 == 1:
            text = json.dumps({'op': source.choice(_WORDS[:9]), 'topic': value(0),
                               'msg': value(0), 'service': value(0)})
            yield text[:source.randrange(1, len(text) + 1)]
        else:
            yield json.dumps(value(0))
    yield from BOMBS


def half_open(url: str, count: int) -> list[socket.socket]:
    """Return connections that never finish their handshake."""
    parts = urlsplit(url)
    return [socket.create_connection((parts.hostname, parts.port)) for _ in range(count)]


async def crowd(url: str, clients: int, frames: int, idle: int) -> None:
    """
    Let clients share random frames and read topics; then half of them vanish without a word.

    :param frames: of all together; each sends the bombs, too.
    :param idle: connections beside them that never finish their handshake.
    """
    connections: list[ClientConnection] = []
    for begin in range(0, clients, _STEP):
        connections += await asyncio.gather(*(
            connect(url, compression=None, max_size=None)
            for _ in range(min(_STEP, clients - begin))))
    held = half_open(url, idle)
    readers = [asyncio.create_task(_drain(connection))
               for number, connection in enumerate(connections, start=1) if number % _IDLE]

    async def misbehave(number: int, connection: ClientConnection) -> None:
        await connection.send(_SUBSCRIBE)
        if number % _IDLE == 0:
            await connection.send(json.dumps({
                'op': 'subscribe', 'topic': '/picture', 'type': 'sensor_msgs/Image',
                'compression': ('none', 'cbor', 'png')[number // _IDLE % 3],
                'fragment_size': 100_000 + number}))
        for frame in random_frames(frames // clients, number):
            await connection.send(frame)
            await asyncio.sleep(0)
        if number % 2 or number % _IDLE == 0:
            connection.transport.abort()
        else:
            await connection.close()

    await asyncio.gather(*map(misbehave, range(1, clients + 1), connections))
    await asyncio.gather(*readers)
    for silent in held:
        silent.close()


async def _drain(connection: ClientConnection) -> None:
    with suppress(WebSocketException):
        async for _ in connection:
            pass


if __name__ == '__main__':
    asyncio.run(crowd(sys.argv[1], *map(int, sys.argv[2:5])))
    print('done', flush=True)
