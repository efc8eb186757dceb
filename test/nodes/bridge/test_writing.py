# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Large frames are written in pieces, as their client takes them."""

import asyncio
from unittest.mock import Mock

from websockets.protocol import State
from websockets.server import ServerProtocol

from armsim_ros.nodes.bridge.server import _Connection, Turns


def test_a_large_frame_waits_for_its_client_and_a_ping_waits_for_the_frame():
    """The pieces come in order; nothing of the protocol's own comes between them."""
    async def run():
        transport, written = Mock(), []
        transport.is_closing.return_value = False
        transport.write.side_effect = lambda data: written.append(bytes(data))
        connection = type('Connection', (_Connection,), {'pending': set()})(
            ServerProtocol(state=State.OPEN), Mock())
        connection.connection_made(transport)
        frame = bytes(range(256)) * 1000
        writing = asyncio.create_task(
            connection.write([frame[:100_000], frame[100_000:]], Turns(4)))
        await asyncio.sleep(0)
        connection.pause_writing()  # as the transport does when its buffer is full
        connection.protocol.send_ping(b'here')
        connection.send_data()
        for _ in range(10):
            await asyncio.sleep(0)
        assert len(b''.join(written)) < len(frame)
        connection.resume_writing()
        await writing
        assert b''.join(written) == frame + b'\x89\x04here'
        assert max(map(len, written)) <= 1 << 16

    asyncio.run(run())
