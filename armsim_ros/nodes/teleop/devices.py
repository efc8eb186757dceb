# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Keys of a terminal, and gamepads by their topic or by the joystick interface of Linux."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
import errno
import os
from pathlib import Path
import select
import signal
import struct
import sys
import termios
import time
import tty
from typing import Protocol

from sensor_msgs.msg import Joy

from armsim_ros.cli.arguments import UsageError
from armsim_ros.clients.ros_client import RosClient
from armsim_ros.errors import ArmsimError, ResourceError


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


TOPIC, DEVICE = '/joy', '/dev/input/js0'
#: Messages of the topic are no older; the usual publishers repeat them 20 times a second [s].
_FRESH = 0.5
#: Time in which a publisher is found [s].
_DISCOVERY = 1.0
#: Linux, struct js_event: time [ms], value, type, number.
_EVENT = struct.Struct('=IhBB')
_BUTTON, _AXIS, _LARGEST = 1, 2, 32767.0


class Gamepad(Protocol):
    """Axes and buttons."""

    def read(self) -> tuple[Sequence[float], Sequence[int]]:
        """Return axes, left and up positive, and buttons; none where it is silent."""


class Joystick:
    """
    A device of Linux's joystick interface.

    :param path: of the device.
    :raises ResourceError: it cannot be opened.
    """

    def __init__(self, path: str) -> None:
        self._path = path
        try:
            self._file = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        except OSError as error:
            raise ResourceError(
                f"the gamepad '{path}' cannot be opened: {error.strerror}; plug it in, join the "
                f"group 'input', or publish {TOPIC}: ros2 run joy joy_node") from None
        self._values: dict[tuple[int, int], int] = {}

    def read(self) -> tuple[list[float], list[int]]:
        """Return axes and buttons after all events that have come."""
        try:
            while True:
                data = os.read(self._file, 64 * _EVENT.size)
                if not data:
                    raise OSError(errno.ENODEV, os.strerror(errno.ENODEV))
                for _, value, kind, number in _EVENT.iter_unpack(data):
                    self._values[kind & (_BUTTON | _AXIS), number] = value
        except BlockingIOError:
            pass
        except OSError as error:
            raise ArmsimError(f"the gamepad '{self._path}' is gone: {error.strerror}") from None
        # Linux has right and down positive.
        return ([-value / _LARGEST for value in self._row(_AXIS)], self._row(_BUTTON))

    def close(self) -> None:
        """Close the device."""
        os.close(self._file)

    def _row(self, kind: int) -> list[int]:
        count = max((number + 1 for each, number in self._values if each == kind), default=0)
        return [self._values.get((kind, number), 0) for number in range(count)]


class JoyTopic:
    """The last message of a topic."""

    def __init__(self, client: RosClient) -> None:
        self._message, self._received = Joy(), 0.0
        client.subscribe(Joy, TOPIC, 1, self._receive)

    def read(self) -> tuple[Sequence[float], Sequence[int]]:
        """Return axes and buttons; none where no message has come for half a second."""
        if time.monotonic() - self._received > _FRESH:
            return (), ()
        return self._message.axes, self._message.buttons

    def require(self, patience: float) -> None:
        """
        Wait for the first message.

        :param patience: [s].
        :raises ArmsimError: none comes.
        """
        deadline = time.monotonic() + patience
        while not self._received:
            if time.monotonic() > deadline:
                raise ArmsimError(
                    f"no message on '{TOPIC}' within {patience:g} s, though it has a publisher; "
                    'is the gamepad plugged in, and autorepeat_rate of joy_node above 2 Hz?')
            time.sleep(0.02)

    def _receive(self, message: Joy) -> None:
        self._message, self._received = message, time.monotonic()


def find_gamepad(client: RosClient, device: str, patience: float) -> Gamepad:
    """
    Return a gamepad: the device that is named, else the topic where it is published, else js0.

    :param device: its path, '' where none is named.
    :param patience: for the first message [s].
    :raises ArmsimError: there is none.
    """
    deadline = time.monotonic() + _DISCOVERY
    while not device and time.monotonic() < deadline:
        if client.node.count_publishers(TOPIC):
            topic = JoyTopic(client)
            topic.require(patience)
            return topic
        time.sleep(0.02)
    if not device and not Path(DEVICE).exists():
        raise ResourceError(
            f"there is no gamepad: neither is '{TOPIC}' published nor is there '{DEVICE}'; plug "
            'it in, or start ros2 run joy joy_node')
    return Joystick(device or DEVICE)
