# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Starts programs, forwards what they print, and stops them together."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
import fcntl
import math
import os
import selectors
import signal
import socket
import subprocess
import threading
import time
from types import FrameType
from typing import IO

from armsim_ros.cli.environment import (
    child_environment,
    die_with_parent,
    MARK,
    signal_group,
    StopLadder,
)
from armsim_ros.errors import USAGE_STATUS

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
        self._descriptor, self._tell_broken = descriptor, broken
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


#: SIGTERM and SIGKILL of programs that do not end [s]: below 2 s, when nothing may be left.
SIGTERM_AFTER, SIGKILL_AFTER = 0.6, 1.5
_STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
#: Events are waited for no longer than this, while the programs run and while they end [s].
_LONGEST_WAIT, _LONGEST_WAIT_AT_END = 1.0, 0.05
#: What our readers have not taken by then is lost [s].
_FLUSH_TIME = 0.3


class Supervisor:
    """
    Runs several programs as a unit: the end of any is the end of all.

    All but the writing happens in the calling thread, which sleeps until a program prints or
    ends or a signal comes.

    :param commands: program name -> the words that start it, in starting order.
    :param spare: programs whose end is reported and ends no other.
    """

    def __init__(self, commands: Mapping[str, Sequence[str]], spare: Sequence[str] = ()) -> None:
        self._commands = commands
        self._spare = frozenset(spare)
        self._children: list[Child] = []
        self._selector = selectors.DefaultSelector()
        self._stop_requests = 0
        self._stopped_since: float | None = None
        self._ladder = StopLadder(SIGTERM_AFTER, SIGKILL_AFTER)
        self._status: int | None = None
        self._refusals: set[str] = set()
        self._listen_to_signals()
        self._outlets = tuple(Outlet(number, self._wake) for number in (1, 2))

    def run(self) -> int:
        """
        Start all, wait for the end, leave no process behind.

        :returns: 0 after SIGINT, SIGTERM or SIGHUP; 2 where a program refused its arguments or
            configuration; 1 where any ended in any other way.
        """
        try:
            for name, command in self._commands.items():
                self._start(name, command)
            while not self._all_ended():
                self._wait_for_events()
                self._look_for_ended()
                if any(outlet.is_broken for outlet in self._outlets):
                    break  # our output is closed: the same as a hang-up
                self._stop_step_by_step()
        finally:
            for child in self._children:
                child.send(signal.SIGKILL)
            for outlet in self._outlets:
                outlet.close(_FLUSH_TIME)
        return self._status or 0

    def _start(self, name: str, command: Sequence[str]) -> None:
        child = Child(name, command)
        self._children.append(child)
        for stream, outlet in zip(child.streams(), self._outlets, strict=True):
            self._selector.register(stream, selectors.EVENT_READ, (stream, child, outlet))

    def _listen_to_signals(self) -> None:
        reader, writer = socket.socketpair()
        reader.setblocking(False)
        writer.setblocking(False)
        signal.set_wakeup_fd(writer.fileno(), warn_on_full_buffer=False)
        self._wakeup = reader, writer
        self._selector.register(reader, selectors.EVENT_READ, None)
        for number in _STOP_SIGNALS:
            signal.signal(number, self._on_stop_signal)
        signal.signal(signal.SIGCHLD, lambda *_: None)

    def _wake(self) -> None:
        """End the wait for events; from any thread."""
        with suppress(OSError):
            self._wakeup[1].send(b'\0')

    def _on_stop_signal(self, _number: int, _frame: FrameType | None) -> None:
        self._stop_requests += 1

    def _wait_for_events(self) -> None:
        longest = _LONGEST_WAIT if self._stopped_since is None else _LONGEST_WAIT_AT_END
        for key, _ in self._selector.select(timeout=longest):
            if key.data is None:
                self._wakeup[0].recv(4096)
            else:
                self._forward(*key.data)

    def _forward(self, stream: IO[bytes], child: Child, outlet: Outlet) -> None:
        for line in child.read_lines(stream):
            if not line.startswith(MARK):
                outlet.write(f'[{child.name}] {line}')
            elif line not in self._refusals:
                # Every program reads the same files and finds the same error.
                speaker = '' if self._refusals else 'bringup: '
                self._refusals.add(line)
                outlet.write(speaker + line.removeprefix(MARK))

    def _look_for_ended(self) -> None:
        for child in self._children:
            if not child.has_ended() or self._is_drained(child):
                continue
            self._drain(child)
            if self._stopped_since is None and not self._stop_requests:
                self._report_loss(child)

    def _is_drained(self, child: Child) -> bool:
        return all(stream.closed for stream in child.streams())

    def _drain(self, child: Child) -> None:
        """Forward what the ended program had still written, and close its pipes."""
        for stream in child.streams():
            outlet = self._selector.get_key(stream).data[2]
            self._forward(stream, child, outlet)
            self._selector.unregister(stream)
            stream.close()

    def _report_loss(self, child: Child) -> None:
        """Report which program was lost and how; it reports a refused configuration itself."""
        if child.name in self._spare:
            self._report(
                f'{child.name} (pid {child.pid}) {child.describe_end()}; the rest goes on')
            return
        if child.status == USAGE_STATUS:
            self._status = USAGE_STATUS
            for other in self._children:
                if not other.last_lines:
                    other.send(signal.SIGKILL)  # still at its imports: nothing is there to end
        else:
            self._status = 1
            others = [other.name for other in self._children if other is not child]
            last = ''.join(f'\n  {line}' for line in child.last_lines)
            self._report(f'{child.name} (pid {child.pid}) {child.describe_end()}; stopping '
                      f'{" and ".join(others) or "nothing else"}'
                      + (f'; its last lines:{last}' if last else '; it had printed nothing'))
        self._begin_stop()

    def _begin_stop(self) -> None:
        if self._stopped_since is None:
            self._stopped_since = time.monotonic()

    def _stop_step_by_step(self) -> None:
        """Send what the schedule has come to; a second request goes to the end of it."""
        if self._stop_requests:
            self._begin_stop()
        if self._stopped_since is None:
            return
        elapsed = time.monotonic() - self._stopped_since
        for number in self._ladder.due(math.inf if self._stop_requests > 1 else elapsed):
            for child in self._children:
                child.send(number)

    def _all_ended(self) -> bool:
        return all(child.has_ended() and self._is_drained(child) for child in self._children)

    def _report(self, text: str) -> None:
        self._outlets[1].write(f'[bringup] {text}')
