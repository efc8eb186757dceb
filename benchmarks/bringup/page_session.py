# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A load that looks at the page as a browser's tab does.

``python -m benchmarks.bringup.page_session ADDRESS`` opens both websockets, reads what comes,
draws nothing. Prints a line when the scene has come, and when it is terminated what it has
received since then.
"""

from __future__ import annotations

import asyncio
from contextlib import suppress
import secrets
import signal
import sys
import time

import msgspec
import viser
from viser import _messages
import websockets.asyncio.client

SETTLED = 'sees the page'
RECEIVED = 'received'
#: The scene counts as loaded when nothing large has come for so long [s].
_QUIET = 2.0


def main(address: str) -> None:
    """Look until a signal comes."""
    with suppress(asyncio.CancelledError):
        asyncio.run(_look(address))


async def _look(address: str) -> None:
    task = asyncio.current_task()
    assert task is not None
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, task.cancel)
    count = {'bytes': 0, 'messages': 0}
    base, key = address.replace('http', 'ws').rstrip('/'), secrets.token_hex(8)

    async def read(connection: websockets.asyncio.client.ClientConnection) -> None:
        async for message in connection:
            count['bytes'] += len(message)
            count['messages'] += 1

    connect = websockets.asyncio.client.connect
    async with connect(f'{base}/panel/{key}', max_size=None) as panel, connect(
            f'{base}/scene/{key}', max_size=None,
            subprotocols=[websockets.Subprotocol(f'viser-v{viser.__version__}')]) as scene:
        readers = [asyncio.create_task(read(each)) for each in (panel, scene)]
        camera = _messages.ViewerCameraMessage(
            wxyz=(1.0, 0.0, 0.0, 0.0), position=(2.0, 0.0, 1.0), fov=1.3, near=0.01, far=1000.0,
            image_height=760, image_width=828, look_at=(0.0, 0.0, 0.0),
            up_direction=(0.0, 0.0, 1.0))
        await scene.send(msgspec.msgpack.encode(camera.as_serializable_dict()))
        await asyncio.sleep(_QUIET)
        print(f'{SETTLED}: {count["bytes"]} bytes', flush=True)
        begun, count['bytes'], count['messages'] = time.monotonic(), 0, 0
        try:
            await asyncio.gather(*readers)
        finally:
            seconds = time.monotonic() - begun
            print(f'{RECEIVED} kB/s={count["bytes"] / seconds / 1000.0:.1f} '
                  f'messages/s={count["messages"] / seconds:.1f}', flush=True)


if __name__ == '__main__':
    main(sys.argv[1])
