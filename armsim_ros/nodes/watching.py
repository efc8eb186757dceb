# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a program reports of itself: waiting for a processor, and answers that were lost."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
import os
from pathlib import Path
import sys
import threading
import time
from types import FrameType
from typing import Any, TextIO
import warnings

#: Period of checking the threads, and the shortest between warnings [s].
PERIOD, SILENCE = 20.0, 60.0
#: Overloaded is a thread that waits for this share of the time, and longer than it computes.
SHARE, RATIO = 0.5, 2.0

Times = Mapping[str, tuple[float, float]]
"""Thread -> time [s] that it has computed, and that it was ready to and did not get to."""


class OverloadWatch:
    """
    Watches how long the threads of this process wait for a processor.

    :param program: the name that lines begin with.
    :param read: returns the computing and waiting times of each thread.
    :param report: takes a line.
    """

    def __init__(
        self, program: str, *, read: Callable[[], Times] = lambda: thread_times(),
        report: Callable[[str], None] = lambda line: _print(line)
    ) -> None:
        self.is_overloaded = False
        self._program, self._read, self._report = program, read, report
        self._before: tuple[float, Times] | None = None
        self._reported_at: float | None = None

    def start(self) -> None:
        """Look now and then, in a thread, as long as the process lives."""
        threading.Thread(target=self._run, name='overload', daemon=True).start()

    def look(self, now: float) -> None:
        """
        Compare with the last check, and report overload.

        :param now: wall time [s].
        """
        times = self._read()
        if self._before is not None:
            then, before = self._before
            used, waited = max(
                (
                    (end[0] - begin[0], end[1] - begin[1])
                    for thread, end in times.items()
                    if (begin := before.get(thread)) is not None),
                key=lambda entry: entry[1],
                default=(0.0, 0.0))
            span = now - then
            self.is_overloaded = waited > SHARE * span and waited > RATIO * used
            if self.is_overloaded and (
                    self._reported_at is None or now - self._reported_at >= SILENCE):
                self._reported_at = now
                self._report(
                    f'{self._program}: this machine is overloaded: of the last {span:.0f} s the '
                    f'program had to wait {waited:.1f} s for a processor (load '
                    f'{os.getloadavg()[0]:.0f} on {os.cpu_count()}); expect delays')
        self._before = now, times

    def _run(self) -> None:
        pause = threading.Event()
        while True:
            self.look(time.monotonic())
            pause.wait(PERIOD)


_watches: list[OverloadWatch] = []


def watch_process(program: str) -> None:
    """Begin to watch this process, under its program's name."""
    watch = OverloadWatch(program)
    _watches.append(watch)
    watch.start()


def is_overloaded() -> bool:
    """Return whether this process was found to starve at the last check."""
    return any(watch.is_overloaded for watch in _watches)


def thread_times() -> Times:
    """Return the times of this process's threads; none where the kernel does not count them."""
    found = {}
    with suppress(OSError):
        for path in Path('/proc/self/task').glob('*/schedstat'):
            with suppress(OSError, ValueError):
                used, waited, _ = map(int, path.read_text(encoding='ascii').split())
                found[path.parent.name] = used * 1e-9, waited * 1e-9
    return found


def _print(line: str) -> None:
    with suppress(OSError):
        print(line, file=sys.stderr, flush=True)


_LOST = 'failed to send response'


def log_lost_answers() -> None:
    """
    Log answers whose client does not receive, from now on.

    Fast DDS waits for the client's reader for the writer's ``max_blocking_time``. rclpy then
    raises a warning, of which Python prints the first alone.
    """
    shown = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], filename: str, lineno: int,
             file: TextIO | None = None, line: str | None = None) -> None:
        if not str(message).startswith(_LOST):
            shown(message, category, filename, lineno, file, line)
            return
        from rclpy.logging import get_logger

        names = (_name(frame) for frame in _frames(sys._getframe(1)))
        name = next(filter(None, names), 'an action')
        get_logger('lost_answers').warning(
            f"a client of '{name}' gets no answer: this process has not discovered the client's "
            'reader in time, or their QoS do not match')

    warnings.filterwarnings('always', _LOST, RuntimeWarning)
    warnings.showwarning = show


def _name(frame: FrameType) -> str:
    server: Any = frame.f_locals.get('self')
    return getattr(server, 'srv_name', '') or getattr(server, '_action_name', '')


def _frames(frame: FrameType | None) -> Iterator[FrameType]:
    while frame is not None:
        yield frame
        frame = frame.f_back
