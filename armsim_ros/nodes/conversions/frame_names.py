# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The frames of a serialized ``tf2_msgs/msg/TFMessage``, without unpacking the rest.

The format is plain CDR of the OMG's DDS-XTypes: a header of four bytes, then little-endian
values, each aligned to its own size from the end of the header on.
"""

from __future__ import annotations

import struct
from struct import unpack_from

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
