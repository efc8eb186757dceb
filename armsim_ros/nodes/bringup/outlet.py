# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""An output that never blocks its writers."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
import os
import threading

#: Lines that wait while the reader is slow; those after them are counted and dropped.
MOST_LINES = 10_000


class Outlet:
    """
    Lines on their way to a file descriptor, written by a thread of their own.

    The reader may pause, as a pager does: the writer here waits, its callers do not.

    :param descriptor: where the lines go.
    :param broken: called once the output is closed.
    """

    def __init__(self, descriptor: int, broken: Callable[[], None]) -> None:
        self.is_broken = False
        self._descriptor = descriptor
        self._tell_broken = broken
        self._lines: deque[str] = deque()
        self._dropped = 0
        self._closed = False
        self._news = threading.Condition()
        self._thread = threading.Thread(target=self._run, name='outlet', daemon=True)
        self._thread.start()

    def write(self, line: str) -> None:
        """Have a line written soon; it is dropped where too many wait already."""
        with self._news:
            if self._dropped or len(self._lines) >= MOST_LINES:
                self._dropped += 1
            else:
                self._lines.append(line)
            self._news.notify()

    def close(self, timeout: float) -> None:
        """Write what waits, as far as it is read within the time [s]."""
        with self._news:
            self._closed = True
            self._news.notify()
        self._thread.join(timeout)

    def _run(self) -> None:
        while lines := self._next():
            try:
                self._write(''.join(f'{line}\n' for line in lines).encode(errors='replace'))
            except OSError:
                self.is_broken = True
                self._tell_broken()
                return

    def _next(self) -> list[str]:
        """Return the lines that wait, at least one; none at the end."""
        with self._news:
            self._news.wait_for(lambda: self._lines or self._dropped or self._closed)
            lines = list(self._lines)
            self._lines.clear()
            if self._dropped:
                lines.append(f'[bringup] {self._dropped} lines were dropped here: output not read')
                self._dropped = 0
            return lines

    def _write(self, block: bytes) -> None:
        while block:
            block = block[os.write(self._descriptor, block) :]
