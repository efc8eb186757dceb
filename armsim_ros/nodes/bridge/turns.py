# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Who is served next, so that many busy clients cannot hold others up."""

from __future__ import annotations

import asyncio
from collections import deque

#: How long frames are served in a pass of the event loop [s].
_SLICE = 0.002


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
