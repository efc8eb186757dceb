# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Passes calls from the control loop and the executor to the publishing thread."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
import time

from rclpy.node import Node

from armsim_ros.nodes.simulation.threads import DutyLimit
from armsim_ros.sim.pacer import Bell

#: The longest wait between checks of the deadlines [s].
_LONGEST_WAIT = 0.05
#: Messages of a source that wait, a second of /clock.
MOST_WAITING = 100


class _Bounded:
    """
    Calls of a source that wait, the oldest first, and as many or more turns for them.

    Neither thread waits for the other: each counts for itself. A turn is counted as taken before
    its call is, so that a call never stays without a turn; a turn that finds no call does nothing.
    """

    def __init__(self, queue: deque[Callable[[], object]], depth: int) -> None:
        self._queue, self._depth = queue, depth
        self._waiting: deque[Callable[[], object]] = deque(maxlen=depth)
        self._given = self._taken = 0

    def post(self, work: Callable[[], object]) -> None:
        self._waiting.append(work)
        if self._given - self._taken < self._depth:
            self._given += 1
            self._queue.append(self._turn)

    def _turn(self) -> None:
        self._taken += 1
        try:
            work = self._waiting.popleft()
        except IndexError:
            return
        work()


class Dispatcher:
    """
    A queue of small calls, made by the publishing thread.

    An executor fills its wait set at every wake-up, which costs more than to publish a
    message; so the loop's messages go out through this queue instead. What it
    repeats is bounded, however late the thread is, and wakes the thread once for
    all messages of a tick.

    :param leaves_out: whether messages may be left out; not where each run is to be like the last.
    """

    def __init__(self, *, leaves_out: bool = True) -> None:
        #: Whether messages may be left out.
        self.leaves_out = leaves_out
        self._queue: deque[Callable[[], object]] = deque()
        self._bell = Bell()
        self._deadlines: list[tuple[float, Callable[[], object]]] = []
        self._stopped = False

    def post(self, work: Callable[[], object]) -> None:
        """Queue a call, in order; never blocks, from any thread."""
        self._queue.append(work)
        self._bell.set()

    def bounded(self, depth: int = MOST_WAITING) -> Callable[[Callable[[], object]], None]:
        """
        Return what posts the calls of a source, of which so many wait at most.

        Of more than that the oldest are not made. They are made after ``wake``.
        """
        if not self.leaves_out:
            return self._queue.append
        return _Bounded(self._queue, depth).post

    def wake(self) -> None:
        """Have queued calls made soon; from any thread."""
        if self._queue:
            self._bell.set()

    def post_later(self, delay: float, work: Callable[[], object]) -> None:
        """Queue a call after ``delay`` [s] of wall time; from any thread."""
        deadline = time.monotonic() + delay
        self.post(lambda: self._deadlines.append((deadline, work)))

    def every(self, period: float, work: Callable[[], object]) -> None:
        """Repeat a call every ``period`` [s] of wall time."""

        def once() -> None:
            self._deadlines.append((time.monotonic() + period, once))
            work()

        self.post_later(period, once)

    def stop(self) -> None:
        """Let ``run`` return; from any thread and from a signal handler."""
        self._stopped = True
        self._bell.set()

    def run(self) -> None:
        """Make the calls until ``stop``."""
        limit = DutyLimit()
        while not self._stopped:
            limit.rest()
            self._bell.wait(_LONGEST_WAIT)
            for _ in range(len(self._queue)):
                if self._stopped:
                    return  # type: ignore[unreachable] # set by another thread meanwhile
                self._queue.popleft()()
            self._call_due()

    def _call_due(self) -> None:
        if not self._deadlines:
            return
        now = time.monotonic()
        due = [work for deadline, work in self._deadlines if deadline <= now]
        if due:
            self._deadlines = [entry for entry in self._deadlines if entry[0] > now]
        for work in due:
            work()


def wake(node: Node) -> None:
    """Let the executor of a node go on with its coroutines; a node without has none waiting."""
    if node.executor is not None:
        node.executor.wake()
