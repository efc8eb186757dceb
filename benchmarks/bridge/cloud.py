# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A client that reads large messages, in a process of its own: they would hold others up in it."""

from __future__ import annotations

import asyncio
import re
import sys
import time

from websockets.asyncio.client import connect

from benchmarks.stack import median

#: Messages that are timed, and the stamp in their frames.
_COUNT, _STAMP = 4, re.compile(rb'"sec":(\d+),"nanosec":(\d+)')


async def seconds(url: str, subscription: str) -> float:
    """Return how long a message takes from its publisher to here [s]."""
    found: list[float] = []
    async with connect(url, compression=None, max_size=None) as connection:
        await connection.send(subscription)
        while len(found) < _COUNT:
            stamp = _STAMP.search(await connection.recv(decode=False), 0, 500)
            assert stamp is not None
            found.append((time.time_ns() - int(stamp[1]) * 10**9 - int(stamp[2])) * 1e-9)
    return median(found)


if __name__ == '__main__':
    print('seconds', asyncio.run(seconds(*sys.argv[1:])), flush=True)
