# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Starts programs, forwards what they print, and stops them together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
import math
import selectors
import signal
import socket
import time
from types import FrameType
from typing import IO

from armsim_ros.cli.environment import MARK, StopLadder
from armsim_ros.errors import USAGE_STATUS
from armsim_ros.nodes.bringup.child import Child, Outlet

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
