# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A gamepad: by its topic, or by the joystick interface of Linux."""

from __future__ import annotations

from collections.abc import Sequence
import errno
import os
from pathlib import Path
import struct
import time
from typing import Protocol

from sensor_msgs.msg import Joy

from armsim_ros.clients.ros_client import RosClient
from armsim_ros.errors import ArmsimError, ResourceError

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
            raise ArmsimError(
                f"the gamepad '{self._path}' is gone: {error.strerror}") from None
        # Linux has right and down positive.
        return ([-value / _LARGEST for value in self._row(_AXIS)], self._row(_BUTTON))

    def close(self) -> None:
        """Close the device."""
        os.close(self._file)

    def _row(self, kind: int) -> list[int]:
        count = max((number + 1 for each, number in self._values if each == kind), default=0)
        return [self._values.get((kind, number), 0) for number in range(count)]


class JoyTopic:
    """
    The last message of a topic.

    :param client: subscribes.
    """

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
