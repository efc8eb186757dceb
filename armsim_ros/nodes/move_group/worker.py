# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Threads that compute, so that the executor's thread never waits, and its coroutines' ticks."""

from __future__ import annotations

from collections.abc import Callable, Generator
import queue
import threading
from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.task import Future


class Job(Future):
    """
    Work that a worker does; the future gets its value or its exception.

    A job that is cancelled before it has begun is not done, and a job that takes turns ends at its
    next turn.
    """

    def __init__(self, work: Callable[[], Any]) -> None:
        super().__init__()  # type: ignore[no-untyped-call] # rclpy's
        self.work: Callable[[], Any] | None = work
        self.turns: Generator[None, None, Any] | None = None
        #: Whether the worker has begun it.
        self.begun = False


class AnyOf:
    """An awaitable that completes when one of several futures is done."""

    def __init__(self, *futures: Future) -> None:
        self._futures = futures

    def __await__(self) -> Generator[None, None, None]:
        """Yield until any is done; the executor goes on with a coroutine whenever it wakes."""
        while not any(future.done() for future in self._futures):
            yield


class Worker:
    """
    A thread that does jobs in order of arrival.

    A job may take turns: work that returns a generator is continued after the other jobs that
    wait, whenever it yields. What it returns at last is its value.

    A coroutine of the executor awaits a job; the executor goes on meanwhile.

    :param name: of the thread.
    """

    def __init__(self, name: str, executor: Executor) -> None:
        self._executor = executor
        self._jobs: queue.SimpleQueue[Job | None] = queue.SimpleQueue()
        self._unfinished = 0
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def submit(self, work: Callable[[], Any]) -> Job:
        """Queue work for the thread."""
        job = Job(work)
        with self._lock:
            self._unfinished += 1
        self._jobs.put(job)
        return job

    def submit_short(self, work: Callable[[], Any]) -> Job:
        """
        Do work at once, on the executor's thread, unless jobs wait: then queue it.

        The executor needs a turn of its own to continue a coroutine that waits, and in a program
        with a hundred endpoints that takes many times as long as short work.
        """
        with self._lock:
            busy = self._unfinished > 0
            self._unfinished += not busy
        if busy:
            return self.submit(work)
        job = Job(work)
        if not self._ends(job):
            self._jobs.put(job)
            return job
        with self._lock:
            self._unfinished -= 1
        return job

    async def idle(self) -> None:
        """Wait until all jobs that were submitted before are done."""
        if self._unfinished:
            await self.submit(lambda: None)

    def close(self, timeout: float = 1.0) -> None:
        """End the thread after its current job; wait up to [s] for that."""
        self._jobs.put(None)
        self._thread.join(timeout)

    def _run(self) -> None:
        while (job := self._jobs.get()) is not None:
            if not job.cancelled() and not self._ends(job):
                self._jobs.put(job)
            else:
                with self._lock:
                    self._unfinished -= 1
                self._executor.wake()
            # The next job may take seconds: its value must not keep the last value alive.
            del job

    @staticmethod
    def _ends(job: Job) -> bool:
        """Do a job, or its next turn; return whether that was the end of it."""
        job.begun = True
        try:
            if job.turns is None:
                work, job.work = job.work, None
                value = work() if work is not None else None
                if not isinstance(value, Generator):
                    job.set_result(value)
                    return True
                job.turns = value
            next(job.turns)
        except StopIteration as end:
            job.set_result(end.value)
        except Exception as error:  # noqa: BLE001 - raised where it is awaited
            job.set_exception(error)
        else:
            return False
        return True


PERIOD = 0.02


class Ticker:
    """
    Wakes waiting coroutines every 20 ms of real time, and on request.

    The timer is stopped while nothing waits.
    """

    def __init__(self, node: Node) -> None:
        self._waiting: list[Future] = []
        self._timer = node.create_timer(
            PERIOD, self._pulse, callback_group=ReentrantCallbackGroup(),
            clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._timer.cancel()

    def next(self) -> Future:
        """Return a future that is done at the next tick."""
        future = Future()
        self._waiting.append(future)
        if self._timer.is_canceled():
            self._timer.reset()
        return future

    def wake(self) -> None:
        """Tick now; call it from the executor's thread."""
        waiting, self._waiting = self._waiting, []
        for future in waiting:
            future.set_result(None)

    def _pulse(self) -> None:
        if self._waiting:
            self.wake()
        else:
            self._timer.cancel()
