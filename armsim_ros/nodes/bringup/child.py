# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A program that bringup started: process group, output and where it goes, end."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
import fcntl
import os
import signal
import subprocess
import threading
from typing import IO

from armsim_ros.cli.environment import child_environment, die_with_parent, signal_group

#: What fits between a program and us, while we are stopped [bytes].
_PIPE_SIZE = 1 << 20
_LAST_LINES = 10


class Child:
    """
    A program in a session of its own that ends when this process ends, however it ends.

    :param name: the program's name, as in ``armsim NAME``.
    :param command: the words that start it.
    """

    def __init__(self, name: str, command: Sequence[str]) -> None:
        self.name = name
        self.last_lines: deque[str] = deque(maxlen=_LAST_LINES)
        self.status: int | None = None
        self._process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            env=child_environment(), start_new_session=True, preexec_fn=die_with_parent())
        self.pid = self._process.pid
        self._rests: dict[int, bytes] = {}
        for stream in self.streams():
            os.set_blocking(stream.fileno(), False)
            with suppress(OSError):  # a user's pipes may be small, if they are many
                fcntl.fcntl(stream.fileno(), fcntl.F_SETPIPE_SZ, _PIPE_SIZE)
            self._rests[stream.fileno()] = b''

    def streams(self) -> tuple[IO[bytes], IO[bytes]]:
        """Return its standard output and standard error."""
        assert self._process.stdout is not None
        assert self._process.stderr is not None
        return self._process.stdout, self._process.stderr

    def read_lines(self, stream: IO[bytes]) -> Iterator[str]:
        """Yield the lines that have come in since the last call; at the end, the rest too."""
        number = stream.fileno()
        while True:
            try:
                block = os.read(number, 65536)
            except BlockingIOError:
                return
            *lines, self._rests[number] = (self._rests[number] + block).split(b'\n')
            if not block:
                if self._rests[number]:
                    lines.append(self._rests[number])
                self._rests[number] = b''
            for line in lines:
                text = line.decode(errors='replace').rstrip('\r')
                self.last_lines.append(text)
                yield text
            if not block:
                return

    def has_ended(self) -> bool:
        """Return whether it ended; then kill what it left in its group and keep its status."""
        if self.status is None:
            flags = os.WEXITED | os.WNOHANG | os.WNOWAIT
            if os.waitid(os.P_PID, self.pid, flags) is not None:
                # Not yet reaped, so the group's number cannot belong to anyone else.
                signal_group(self.pid, signal.SIGKILL)
                self.status = self._process.wait()
        return self.status is not None

    def send(self, number: signal.Signals) -> None:
        """Send a signal to its whole process group, if it still runs."""
        if not self.has_ended():
            signal_group(self.pid, number)

    def describe_end(self) -> str:
        """Return how it ended, as the end of a sentence."""
        assert self.status is not None
        if self.status >= 0:
            return f'ended with exit status {self.status}'
        try:
            name = signal.Signals(-self.status).name
        except ValueError:
            name = 'unknown'
        return f'was killed by signal {-self.status} ({name})'


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
