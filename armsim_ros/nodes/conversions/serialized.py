# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Messages of one shape, serialized once and changed in place."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from builtin_interfaces.msg import Time
import numpy as np
from numpy.typing import NDArray
from rclpy.serialization import serialize_message

from armsim_ros.arrays import Vector
from armsim_ros.nodes.conversions.time import fill_time, NANOSECONDS

#: A time that no other part of a message looks like [ns].
_MARK_NS = 0x51B2_43D7 * NANOSECONDS + 0x1A2C_3E4F


class SerializedMessage:
    """
    A message of which only stamps and numbers change.

    To turn a message of many parts into what is sent costs some ten times as much as to send it.
    Where the parts are is found out once, by marks.

    :param message: all else of it stays as it is.
    :param stamps: its stamps, which are equal.
    :param numbers: owner and name of the 64 bit floating point fields that change.
    """

    def __init__(
        self, message: Any, stamps: Sequence[Time], numbers: Sequence[tuple[Any, str]]
    ) -> None:
        for stamp in stamps:
            fill_time(stamp, _MARK_NS)
        marks = np.pi * 1e-200 * (1.0 + np.arange(len(numbers)))
        for (owner, name), mark in zip(numbers, marks.tolist(), strict=True):
            setattr(owner, name, mark)
        data: bytes = serialize_message(message)
        self._bytes = np.frombuffer(bytearray(data), np.uint8)
        self._stamps = _places(data, _stamp(_MARK_NS), len(stamps))
        self._numbers = np.concatenate(
            [np.empty((0, 8), np.intp), *(_places(data, mark.tobytes(), 1) for mark in marks)])

    def set_numbers(self, values: Vector) -> None:
        """Write all numbers (n,), in their order."""
        self._bytes[self._numbers] = np.asarray(values, float).view(np.uint8).reshape(-1, 8)

    def at(self, time_ns: int) -> bytes:
        """Return what is to be sent at a time [ns]."""
        self._bytes[self._stamps] = np.frombuffer(_stamp(time_ns), np.uint8)
        return self._bytes.tobytes()


def _stamp(time_ns: int) -> bytes:
    return np.array(divmod(time_ns, NANOSECONDS), np.uint32).tobytes()


def _places(data: bytes, mark: bytes, count: int) -> NDArray[np.intp]:
    """Return where the bytes of a mark are that is there so many times: (count, bytes)."""
    begins, begin = [], data.find(mark)
    while begin >= 0:
        begins.append(begin)
        begin = data.find(mark, begin + 1)
    if len(begins) != count:
        raise ValueError(
            f'the middleware serializes {count} equal fields so that {len(begins)} are found')
    return np.array(begins, np.intp)[:, None] + np.arange(len(mark))
