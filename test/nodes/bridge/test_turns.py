# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Busy clients share the time between two passes of the event loop."""

import asyncio
import time

from armsim_ros.nodes.bridge.server import Turns


def test_busy_clients_hold_nobody_up():
    """However many they are; each is served."""
    async def run():
        turns, served, passes = Turns(4), [0] * 100, []

        async def busy(index):
            while True:
                await turns.take()
                time.sleep(0.0005)
                served[index] += 1

        tasks = [asyncio.create_task(busy(index)) for index in range(100)]
        while min(served) < 5:
            before = sum(served)
            await asyncio.sleep(0)
            passes.append(sum(served) - before)
        for task in tasks:
            task.cancel()
        return passes

    assert max(asyncio.run(run())) <= 8
