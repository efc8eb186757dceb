# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Serialized messages: of a fixed shape, changed in place; and frames of a ``TFMessage``.

The format is plain CDR of the OMG's DDS-XTypes: a header of four bytes, then little-endian
values, each aligned to its own size from the end of the header on.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence
import struct
from struct import unpack_from
from typing import Any

from builtin_interfaces.msg import Duration, Time
import numpy as np
from numpy.typing import NDArray
from rclpy.serialization import serialize_message

from armsim_ros.arrays import Vector
from armsim_ros.nodes.conversions.time import fill_time, NANOSECONDS

#: A time that no other part of a message looks like [ns].
_MARK_NS = 0x51B2_43D7 * NANOSECONDS + 0x1A2C_3E4F


class SerializedMessage:
    """
    A message of which only stamps, durations and numbers change.

    To turn a message of many parts into what is sent costs some ten times as much as to send it.
    Where the parts are is found out once, by marks.

    :param message: all else of it stays as it is.
    :param stamps: its stamps, which are equal.
    :param numbers: owner and name of the 64 bit floating point fields that change, or of whole
        arrays of them, which keep their length.
    :param durations: its durations that change, each for itself.
    """

    def __init__(
        self, message: Any, stamps: Sequence[Time], numbers: Sequence[tuple[Any, str]],
        durations: Sequence[Duration] = (),
    ) -> None:
        for stamp in stamps:
            fill_time(stamp, _MARK_NS)
        spans = [_MARK_NS + (k + 1) * (NANOSECONDS + 1) for k in range(len(durations))]
        for duration, span in zip(durations, spans, strict=True):
            fill_time(duration, span)
        marks: list[float] = []
        for owner, name in numbers:
            value = getattr(owner, name)
            begin = len(marks)
            marks += [np.pi * 1e-200 * (1.0 + begin + k)
                      for k in range(len(value) if isinstance(value, array) else 1)]
            setattr(owner, name, (
                array('d', marks[begin:]) if isinstance(value, array) else marks[begin]))
        data: bytes = serialize_message(message)
        # Numbers are aligned behind the header of 4 bytes.
        room = np.zeros(-(-(4 + len(data)) // 8), np.float64)
        self._eights, self._fours = room, room.view(np.uint32)
        self._bytes = room.view(np.uint8)[4 : 4 + len(data)]
        self._bytes[:] = np.frombuffer(data, np.uint8)
        self._numbers = np.array(
            [_places(data, np.float64(mark).tobytes(), 1, 8)[0] for mark in marks], np.intp)
        self._stamps, self._durations = (
            np.array(places, np.intp)[:, None] + np.arange(2) for places in (
                _places(data, _stamps(_MARK_NS).tobytes(), len(stamps), 4),
                [_places(data, _stamps(span).tobytes(), 1, 4)[0] for span in spans]))

    def set_numbers(self, values: Vector) -> None:
        """Write all numbers (n,), in their order."""
        self._eights[self._numbers] = values

    def set_durations(self, values_ns: NDArray[np.int64]) -> None:
        """Write all durations (k,) [ns], in their order."""
        self._fours[self._durations] = _stamps(values_ns)

    def at(self, time_ns: int) -> bytes:
        """Return what is to be sent at a time [ns]."""
        self._fours[self._stamps] = _stamps(time_ns)
        return self._bytes.tobytes()


def _stamps(times_ns: int | NDArray[np.int64]) -> NDArray[np.uint32]:
    """Return a time (2,) or several (k, 2) [ns] as seconds and nanoseconds."""
    return np.array(divmod(times_ns, NANOSECONDS), np.uint32).T


def _places(data: bytes, mark: bytes, count: int, size: int) -> list[int]:
    """
    Return where a mark is that is there so many times, the header's 4 bytes taken as 8.

    Behind the message the middleware may leave bytes of earlier ones, with marks of those.

    :param size: of what is counted and aligned [bytes].
    """
    begins, begin = [], data.find(mark)
    while begin >= 0:
        begins.append(begin + 4)
        begin = data.find(mark, begin + 1)
    del begins[count:]
    if len(begins) != count or any(begin % size for begin in begins):
        raise ValueError(
            f'the middleware serializes {count} equal fields so that {len(begins)} are found, '
            f'or not every {size} bytes')
    return [begin // size for begin in begins]


_HEADER = b'\x00\x01\x00\x00'
#: Bytes of a stamp, and of a translation and a rotation as seven doubles.
_STAMP, _TRANSFORM = 8, 56


def child_frame_ids(serialized: bytes) -> list[str] | None:
    """
    Return the child frames of all transforms of a message.

    :returns: None where the bytes are not plain little-endian CDR; unpack the message then.
    """
    if serialized[:4] != _HEADER:
        return None
    body = memoryview(serialized)[4:]
    names = []
    try:
        (count,) = unpack_from('<I', body, 0)
        end = 4
        for _ in range(count):
            end = _end_of_string(body, _aligned(end, 4) + _STAMP)
            begin = _aligned(end, 4) + 4
            end = _end_of_string(body, begin - 4)
            names.append(str(body[begin : end - 1], 'utf-8'))
            end = _aligned(end, 8) + _TRANSFORM
    except (struct.error, UnicodeDecodeError):
        return None
    return names


def _end_of_string(body: memoryview, begin: int) -> int:
    (length,) = unpack_from('<I', body, begin)
    return begin + 4 + int(length)


def _aligned(offset: int, size: int) -> int:
    return offset + -offset % size
