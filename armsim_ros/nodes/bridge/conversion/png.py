# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Text as a picture: the compression ``png`` of rosbridge."""

from __future__ import annotations

from base64 import b64encode
import math
import struct
import zlib

#: The eight bytes that a PNG begins with (https://www.w3.org/TR/png-3/#5PNG-file-signature).
_SIGNATURE = b'\x89PNG\r\n\x1a\n'
_DEPTH, _RGB = 8, 2


def to_png(text: str) -> str:
    """
    Return the base64 of a PNG whose RGB bytes are the text, padded with newlines.

    The picture is about square; its lines are not filtered.
    """
    data = text.encode()
    width = max(1, math.isqrt(len(data) // 3))
    height = max(1, math.ceil(len(data) / (3 * width)))
    data = data.ljust(3 * width * height, b'\n')
    stride = 3 * width
    lines = b''.join(b'\0' + data[row:row + stride] for row in range(0, len(data), stride))
    header = struct.pack('>IIBBBBB', width, height, _DEPTH, _RGB, 0, 0, 0)
    return b64encode(b''.join((
        _SIGNATURE, _chunk(b'IHDR', header), _chunk(b'IDAT', zlib.compress(lines, 1)),
        _chunk(b'IEND', b'')))).decode('ascii')


def _chunk(name: bytes, content: bytes) -> bytes:
    return struct.pack('>I', len(content)) + name + content + struct.pack(
        '>I', zlib.crc32(name + content))
