# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Keys as they are pressed, and signals that end a program in order."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
import os
import select
import signal
import sys
import termios
import time
import tty

from armsim_ros.cli.arguments import UsageError


class Ending:
    """Whether the program is to end; set by SIGINT, SIGTERM and SIGHUP."""

    def __init__(self) -> None:
        self.signal = 0

    def __bool__(self) -> bool:
        """Return whether it is to end."""
        return self.signal != 0

    @property
    def status(self) -> int:
        """Exit status: 0 after Ctrl-C, which is the usual end."""
        return 0 if self.signal in (0, signal.SIGINT) else 128 + self.signal


@contextmanager
def ending_by_signals() -> Iterator[Ending]:
    """Have signals end the loop of the program, so that the arm is halted first; a second, all."""
    ending = Ending()

    def note(number: int, _frame: object) -> None:
        if ending:  # what the program waits for does not come
            raise KeyboardInterrupt
        ending.signal = number

    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    usual = {number: signal.signal(number, note) for number in numbers}
    try:
        yield ending
    finally:
        for number, handler in usual.items():
            signal.signal(number, handler)


class Terminal:
    """
    Keys of standard input as they are pressed, and a line of status.

    :param ending: is set where the terminal is gone.
    :param has_keys: whether standard input is a terminal; without, no key is ever pressed.
    """

    def __init__(self, ending: Ending, *, has_keys: bool) -> None:
        self._ending, self._has_keys = ending, has_keys
        self._shown = ''

    def read(self, seconds: float) -> str:
        """Return the keys that are pressed within a time; it takes that time."""
        deadline, text = time.monotonic() + seconds, b''
        while not self._ending:
            left = max(0.0, deadline - time.monotonic())
            if not self._has_keys:
                time.sleep(left)
            elif select.select([sys.stdin], [], [], left)[0]:
                text += self._read_now()
            if left == 0.0:
                break
        return text.decode(errors='replace')

    def show(self, text: str) -> None:
        """Print a line in place of the last, where it is another."""
        if text == self._shown:
            return
        self._shown = text
        if self._has_keys:
            print(f'\r\x1b[K{text}', end='', flush=True)
        elif text:
            print(text, flush=True)

    def _read_now(self) -> bytes:
        try:
            found = os.read(sys.stdin.fileno(), 1000)
        except OSError:
            found = b''
        if not found:
            self._ending.signal = signal.SIGHUP
        return found


@contextmanager
def terminal(ending: Ending, *, needs_keys: bool) -> Iterator[Terminal]:
    """
    Read keys as they are pressed, and restore the terminal afterwards.

    :raises UsageError: keys are needed, and standard input is not a terminal.
    """
    if not sys.stdin.isatty():
        if needs_keys:
            raise UsageError('keys are read from a terminal, which standard input is not; start '
                             'teleop in a terminal (docker run -it, ssh -t)')
        yield Terminal(ending, has_keys=False)
        return
    before = termios.tcgetattr(sys.stdin)
    tty.setcbreak(sys.stdin)
    try:
        yield Terminal(ending, has_keys=True)
    finally:
        with suppress(OSError, termios.error):  # where the terminal is gone
            termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)
            print(flush=True)


def paced(ending: Ending, period: float, screen: Terminal) -> Iterator[tuple[float, str]]:
    """
    Yield time [s] and pressed keys once per period until the program is to end.

    :param period: [s].
    """
    due, keys = time.monotonic(), ''
    while not ending:
        now = time.monotonic()
        yield now, keys
        due = max(due + period, now)
        keys = screen.read(due - time.monotonic())
