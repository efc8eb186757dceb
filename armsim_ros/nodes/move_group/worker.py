# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Threads that compute, so that the executor's thread never waits."""

from __future__ import annotations

from collections.abc import Callable
import queue
import threading
from typing import Any

from rclpy.executors import Executor
from rclpy.task import Future


class Worker:
    """
    One thread that runs jobs in the order of their arrival.

    A coroutine of the executor awaits the future of a job; the executor goes on meanwhile.

    :param name: of the thread.
    :param executor: whose coroutines wait for the jobs.
    """

    def __init__(self, name: str, executor: Executor) -> None:
        """Start the thread."""
        self._executor = executor
        self._jobs: queue.SimpleQueue[tuple[Callable[[], Any], Future] | None]
        self._jobs = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def submit(self, job: Callable[[], Any]) -> Future:
        """Run a job in the thread; the future gets its value or its exception."""
        future = Future()
        self._jobs.put((job, future))
        return future

    def close(self, timeout: float = 1.0) -> None:
        """End the thread after the job that it runs; wait [s] for that."""
        self._jobs.put(None)
        self._thread.join(timeout)

    def _run(self) -> None:
        while (item := self._jobs.get()) is not None:
            job, future = item
            try:
                future.set_result(job())
            except Exception as error:  # noqa: BLE001 - raised where it is awaited
                future.set_exception(error)
            self._executor.wake()
            # The next job may take seconds: its value must not keep the last one alive.
            del item, job, future
