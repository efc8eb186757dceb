# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The only place that reads the wall clock and sleeps: it keeps a loop to absolute deadlines."""

from __future__ import annotations

from array import array
from collections.abc import Callable
from contextlib import suppress
import ctypes
from dataclasses import dataclass
import gc
import os
import sys
import threading
import time
from typing import Protocol

import numpy as np

#: Time after which a thread that computes in Python yields [s]; the default is 5 ms.
SWITCH_INTERVAL = 1e-4
_PR_SET_TIMERSLACK = 29


def prefer_latency() -> None:
    """
    Make the process quick to answer; call it once, after everything is loaded.

    Threads yield sooner, and what exists now is no longer visited by the garbage collector.
    """
    sys.setswitchinterval(SWITCH_INTERVAL)
    gc.collect()
    gc.freeze()


def prioritize_thread(priority: int) -> bool:
    """
    Ask for SCHED_FIFO and exact timers for the calling thread.

    :param priority: 1 to 99; 0 asks for exact timers alone.
    :returns: whether the thread has the priority; without the permission it goes on as it was.
    """
    if not sys.platform.startswith('linux'):
        return False
    ctypes.CDLL(None).prctl(_PR_SET_TIMERSLACK, ctypes.c_ulong(1000), 0, 0, 0)
    if priority <= 0:
        return False
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except OSError:
        return False
    return True


#: Waits whose lateness is kept for the percentiles; to sort more would hold up other threads.
HISTORY = 10_000
#: Wall time that a loop without a pace leaves to others in between [ns].
BREATH = 100_000
#: Share of its time that a loop which cannot keep the pace leaves to others, checked after so
#: many waits without a sleep; of what is beyond so long a time [ns] not all was work.
LEFT_TO_OTHERS, SLEEPLESS_WAITS, LONGEST_WORK_NS = 0.2, 20, 100_000_000
#: The first seconds [ns].
START_NS = 5_000_000_000
#: Wall time over which the pace is measured [ns].
PACE_WINDOW_NS = 1_000_000_000


@dataclass(frozen=True, slots=True)
class PaceStatistics:
    """
    How well the deadlines were kept.

    :param ticks: deadlines so far.
    :param p50_ns: median lateness of the recent waits [ns].
    :param p99_ns: 99th percentile of it [ns].
    :param max_ns: largest lateness of the recent waits [ns].
    :param overruns: waits that began after the next deadline already, since the start.
    :param dropped_ns: time that was given up instead of made up, since the start [ns].
    :param pace: time of the deadlines by wall time over the last second; 1 is kept.
    """

    ticks: int
    p50_ns: int
    p99_ns: int
    max_ns: int
    overruns: int
    dropped_ns: int
    pace: float


class Alarm(Protocol):
    """What ends a doze before its time; such as ``Bell``."""

    def wait(self, timeout: float, /) -> bool:
        """Wait so long at most [s]; return whether it was set."""

    def set(self) -> None:
        """End the present wait, or the next."""

    def clear(self) -> None:
        """Take note of it."""


class Bell:
    """
    Wakes the thread that waits for it; any thread, and any signal handler, rings.

    It does what ``threading.Event`` does with a lock for each wait, with a single lock.
    """

    __slots__ = ('_lock',)

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._lock.acquire()

    def wait(self, timeout: float, /) -> bool:
        """Wait so long at most [s]; return whether it rang, which is then taken note of."""
        return self._lock.acquire(timeout=timeout)

    def set(self) -> None:
        """End the present wait, or the next."""
        with suppress(RuntimeError):  # it rings already
            self._lock.release()

    def clear(self) -> None:
        """Take note of it."""
        self._lock.acquire(blocking=False)


class Pacer:
    """
    Waits for deadlines that are a period apart.

    A late tick is followed by ticks without a wait until the delay is made up; what is beyond
    ``catch_up_ns`` is dropped and counted, and a part of the time is left to others: a thread of
    real-time priority that never sleeps would starve them. One thread waits; others may ask for
    statistics.

    :param clock: returns monotonic time [ns].
    :param sleep: sleeps for a time [s].
    :param spin_ns: last part of each wait spent polling the clock [ns].
    :param catch_up_ns: delay that is made up [ns].
    :param catch_up_at_start_ns: delay that is made up in the first seconds [ns], in which a
        program still has other work to do.
    :param alarm: ends a ``doze`` when another thread sets it.
    """

    def __init__(
        self, *, clock: Callable[[], int] = time.monotonic_ns,
        sleep: Callable[[float], None] = time.sleep, spin_ns: int = 0,
        catch_up_ns: int = 100_000_000, catch_up_at_start_ns: int = 0, alarm: Alarm | None = None
    ) -> None:
        self.alarm: Alarm = alarm or Bell()
        self._clock, self._sleep, self._spin_ns = clock, sleep, spin_ns
        self._catch_up_ns = catch_up_ns
        self._catch_up_at_start_ns = max(catch_up_at_start_ns, catch_up_ns)
        self._lateness = array('q', bytes(8 * HISTORY))
        self.start()

    def start(self) -> None:
        """Put the next deadline a period from now and forget the statistics."""
        self._deadline = float(self._clock())
        self._started = self._deadline
        self._ticks = self._waits = self._overruns = 0
        self._dropped_ns = 0.0
        self._pace = 1.0
        self._window_wall, self._window_paced = self._clock(), 0.0
        self._slept_until, self._sleepless = self._clock(), 0

    def breathe(self) -> None:
        """Let others run for a moment, where no pace is kept; the next deadline counts from it."""
        self._sleep(BREATH * 1e-9)
        self._deadline = float(self._clock())

    def wait(self, period_ns: float) -> int:
        """
        Wait until a period after the last deadline.

        :param period_ns: wall time of the period [ns].
        :returns: how late it is at the return [ns].
        """
        self._deadline += period_ns
        ahead = self._deadline - self._clock()
        if ahead > 0.0:
            if ahead > self._spin_ns:
                self._sleep((ahead - self._spin_ns) * 1e-9)
            while self._spin_ns and self._clock() < self._deadline:
                pass
            self._slept_until, self._sleepless = self._clock(), 0
        else:
            self._sleepless += 1
            if -ahead > period_ns:
                self._overruns += 1
                starting = self._deadline - self._started < START_NS
                made_up = self._catch_up_at_start_ns if starting else self._catch_up_ns
                excess = -ahead - max(made_up, period_ns)
                if excess > 0.0:
                    self._dropped_ns += excess
                    self._deadline += excess
                    self._give_way()
        now = self._clock()
        late = max(0, int(now - self._deadline))
        self._lateness[self._waits % HISTORY] = late
        self._waits += 1
        self._ticks += 1
        self._window_paced += period_ns
        if now - self._window_wall >= PACE_WINDOW_NS:
            self._pace = self._window_paced / (now - self._window_wall)
            self._window_wall, self._window_paced = now, 0.0
        return late

    def _give_way(self) -> None:
        """Sleep for a part of the time since the last sleep, where that was many waits ago."""
        if self._sleepless >= SLEEPLESS_WAITS:
            work = min(self._clock() - self._slept_until, LONGEST_WORK_NS)
            self._sleep(work * 1e-9 * LEFT_TO_OTHERS / (1.0 - LEFT_TO_OTHERS))
            self._slept_until, self._sleepless = self._clock(), 0

    def doze(self, period_ns: float, count: int) -> int:
        """
        Wait for the last of some deadlines without interruption, or until the alarm is set.

        :param period_ns: wall time of a period [ns].
        :param count: deadlines to wait for.
        :returns: how many of them have come; all, where the alarm was not set.
        """
        ahead = self._deadline + count * period_ns - self._clock()
        if ahead <= period_ns or not self.alarm.wait((ahead - self._spin_ns) * 1e-9):
            self.wait(count * period_ns)
            self._ticks += count - 1
            return count
        come = min(count, max(0, int((self._clock() - self._deadline) // period_ns)))
        self._deadline += come * period_ns
        self._ticks += come
        self._window_paced += come * period_ns
        return come

    def statistics(self) -> PaceStatistics:
        """Return how well the deadlines were kept; from any thread."""
        waits = min(self._waits, HISTORY)
        recent = np.array(self._lateness[:waits] or [0], dtype=np.int64)
        p50, p99 = np.percentile(recent, (50, 99))
        return PaceStatistics(
            self._ticks, int(p50), int(p99), int(recent.max()), self._overruns,
            int(self._dropped_ns), self._pace)
