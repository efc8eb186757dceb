# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The control thread and the executor's: their failures, and the priority of the first."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
import math
import os
from pathlib import Path
import random
import threading
import time
import traceback

from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.impl.rcutils_logger import RcutilsLogger

from armsim_ros.sim.control_loop import ControlLoop
from armsim_ros.sim.pacer import prioritize_thread


def prioritize_process(control_priority: int) -> bool:
    """
    Give the calling thread, and all that it starts from now on, SCHED_FIFO priority 1.

    Call it before the first node exists, so that the middleware's threads have it too. The
    control thread shares the interpreter's lock with all Python threads, and those share
    the middleware's locks with its threads: were one of them preempted by another program while
    it holds a lock, the control thread would wait for that program: with ten clients on two
    processors the 99th percentile of its lateness is then tens of milliseconds instead of a
    third of a core (``python -m benchmarks control_thread``). What they may use is limited, see
    :class:`DutyLimit`.

    :param control_priority: of the control thread; 0 asks for none here either.
    :returns: whether there is the permission.
    """
    return prioritize_thread(min(1, control_priority))


class ControlThread:
    """Runs the control loop."""

    def __init__(self, loop: ControlLoop) -> None:
        self.failure = ''
        self._loop = loop
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name='control', daemon=True)

    @property
    def failed(self) -> bool:
        """Whether the loop has ended by itself; ``failure`` is the reason."""
        return bool(self.failure)

    def start(self) -> None:
        """Start to tick."""
        self._thread.start()

    def stop(self, timeout: float) -> None:
        """End the loop and wait for it, at most ``timeout`` [s]."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(timeout)

    def _run(self) -> None:
        try:
            self._loop.run(self._stop)
        except Exception:  # noqa: BLE001 - whatever it is, the program must report it and end
            self.failure = traceback.format_exc()


class ExecutorThread:
    """Spins an executor; a callback's exception is logged, and the others go on."""

    def __init__(self, executor: SingleThreadedExecutor, logger: RcutilsLogger) -> None:
        self._executor, self._logger = executor, logger
        self._stopped = False
        self._thread = threading.Thread(target=self._run, name='executor', daemon=True)

    def start(self) -> None:
        """Start to spin."""
        self._thread.start()

    def stop(self, timeout: float) -> None:
        """End the executor and wait for it, at most ``timeout`` [s]."""
        self._stopped = True
        self._executor.create_task(lambda: None)  # a mere wake does not end spin_once
        if self._thread.is_alive():
            self._thread.join(timeout)
        self._executor.shutdown(0.0)

    def _run(self) -> None:
        limit = DutyLimit()
        while not self._stopped:
            limit.rest()
            try:
                self._executor.spin_once()
            except ExternalShutdownException:
                return
            except rclpy_implementation.RCLError as error:
                self._logger.warning(f'an answer was not delivered: {error}')
            except Exception:  # noqa: BLE001 - no request may end the program
                self._logger.error(
                    'a request failed inside the program; please report this:\n'
                    + traceback.format_exc())


#: How often the machine is checked [s], each time a bit earlier or later than other simulations.
PERIOD = 2.0
#: Share of the time in which some program waits for a processor: priority is given up above the
#: first value, and taken again below the second.
PRESSURE, EASED = 0.5, 0.25
#: Share of all processors that programs in real time may use under pressure.
MOST = 0.5
#: Priority that was given up is not taken again sooner [s].
REST = 30.0
#: What is taken again must fit into this part of that share.
MARGIN = 0.8
#: SCHED_FIFO priority of the checks: above the simulations that they are to restrain.
CHECKS = 90
_TICKS = os.sysconf('SC_CLK_TCK') if hasattr(os, 'sysconf') else 100


class PriorityWatch:
    """
    Checks whether real-time programs starve others, and switches this process's priority.

    Real-time threads come before all others, so a few simulations can take a machine for
    themselves. A single simulation uses little, and keeps its priority under any load.

    :param switch: takes whether this process is to have real-time priority.
    :param report: takes a line for the log.
    :param waited: reads the time in which some program waited for a processor so far [s].
    :param used: reads process id -> processor time [s] of all real-time programs.
    :param processors: of the machine.
    """

    def __init__(
        self, switch: Callable[[bool], None], report: Callable[[str], None], *,
        waited: Callable[[], float] = lambda: time_under_pressure(),
        used: Callable[[], Mapping[int, float]] = lambda: real_time_use(),
        processors: int = os.cpu_count() or 1
    ) -> None:
        self._switch, self._report, self._waited = switch, report, waited
        self._last = 0.0, math.inf
        self._used, self._processors = used, processors
        self._before: tuple[float, Mapping[int, float]] | None = None
        #: What this process used when it gave way, as a share of all processors; None: it has not.
        self._given_up: float | None = None
        self._rests_until = 0.0

    def start(self) -> None:
        """Check now and then, in a thread, as long as the process lives."""
        threading.Thread(target=self._run, name='priority', daemon=True).start()

    def check(self, now: float) -> None:
        """
        Compare with the last check, and switch where that is due.

        :param now: wall time [s].
        """
        waited = self._waited()
        pressure = (waited - self._last[1]) / (now - self._last[0] or 1.0)
        self._last = now, waited
        if self._given_up is None and pressure < PRESSURE:
            self._before = None
            return
        before, used = self._before, self._used()
        self._before = now, used
        if before is None:
            return
        span = (now - before[0]) * self._processors
        shares = {process: (end - before[1].get(process, end)) / span
                  for process, end in used.items()}
        share = sum(shares.values())
        if self._given_up is None:
            if share > MOST:
                self._given_up = shares.get(os.getpid(), 0.0)
                self._rests_until = now + REST
                self._switch(False)
                self._report(
                    f'real-time priority given up: programs wait for a processor {pressure:.0%} '
                    f'of the time, while those in real time use {share:.0%} of all processors')
        elif now >= self._rests_until and (
                pressure < EASED or share + self._given_up < MARGIN * MOST):
            self._given_up = self._before = None
            self._switch(True)
            self._report('real-time priority taken again')

    def _run(self) -> None:
        pause = threading.Event()
        with suppress(OSError):  # without the permission there is nothing to give up either
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(CHECKS))
        while True:
            pause.wait(PERIOD * random.uniform(0.7, 1.3))
            self.check(time.monotonic())


class RealTimeThreads:
    """The real-time priorities of this process's threads, which can be put off for a while."""

    def __init__(self) -> None:
        self._priorities: dict[int, int] = {}

    def switch(self, real_time: bool) -> None:
        """Give all threads their priorities again, those that are new the least; or none."""
        for path in Path('/proc/self/task').iterdir():
            thread = int(path.name)
            with suppress(OSError):  # it has just ended
                if real_time:
                    priority = os.sched_param(self._priorities.get(thread, 1))
                    os.sched_setscheduler(thread, os.SCHED_FIFO, priority)
                elif os.sched_getscheduler(thread) == os.SCHED_FIFO:
                    self._priorities[thread] = os.sched_getparam(thread).sched_priority
                    os.sched_setscheduler(thread, os.SCHED_OTHER, os.sched_param(0))


def time_under_pressure() -> float:
    """Return the time in which some program waited for a processor [s]; 0 if it is not known."""
    with suppress(OSError, ValueError, IndexError):
        text = Path('/proc/pressure/cpu').read_text(encoding='ascii')
        return int(text.split('total=')[1].split()[0]) * 1e-6
    return 0.0


def real_time_use() -> dict[int, float]:
    """Return process id -> processor time [s] of processes whose main thread is real-time."""
    found = {}
    for path in Path('/proc').glob('[0-9]*/stat'):
        with suppress(OSError, ValueError, IndexError):
            fields = path.read_text(encoding='utf-8', errors='replace').rpartition(')')[2].split()
            if int(fields[38]) in (os.SCHED_FIFO, os.SCHED_RR):
                found[int(path.parent.name)] = (int(fields[11]) + int(fields[12])) / _TICKS
    return found


class DutyLimit:
    """
    Keeps a flooded real-time thread from starving other programs.

    :param share: of the time that the thread may compute.
    :param window: over which the share is measured [s].
    """

    def __init__(self, share: float = 0.8, window: float = 0.1) -> None:
        """Start counting in the thread that calls ``rest``."""
        self._share, self._window = share, window
        self._begin = self._used = 0.0

    def rest(self) -> None:
        """Sleep until the thread is down to its share."""
        elapsed = time.monotonic() - self._begin
        if elapsed < self._window:
            return
        used = time.thread_time() - self._used
        if elapsed < 2.0 * self._window and used > self._share * elapsed:
            time.sleep(used / self._share - elapsed)
        self._begin, self._used = time.monotonic(), time.thread_time()
