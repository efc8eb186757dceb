# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Frames of websockets, and messages cut into fragments of rosbridge."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator
import itertools
import json
from json.decoder import JSONArray  # type: ignore[attr-defined] # not in the stubs
from json.scanner import py_make_scanner  # type: ignore[attr-defined] # not in the stubs
import math
import re
import struct
from typing import Any
import zlib

from armsim_ros.nodes.bridge.interfaces import RefusalError
from armsim_ros.nodes.json_text import json_pieces, to_json

#: Fragments of incoming messages, for each client [bytes, messages].
MOST_BYTES, MOST_FRAGMENTED = 10_000_000, 8
SMALLEST_FRAGMENT = 64
#: From this size on text is read by a decoder that lets other threads run; json's holds them up
#: for 25 ms per megabyte of numbers [characters].
_LONG = 2_000_000
#: A number, or an object of numbers and texts that ends soon [characters].
_SHORT = re.compile(r'[-0-9]|\{[^][{}"]*(?:"[^"\\]*"[^][{}"]*)*\}')
_SOON = 1000
_TEXT, _BINARY = 0x81, 0x82
#: From this size on the parts of a frame are written as they are, not copied [bytes].
_SMALL = 1 << 16
#: The eight bytes that a PNG begins with (https://www.w3.org/TR/png-3/#5PNG-file-signature).
_SIGNATURE = b'\x89PNG\r\n\x1a\n'
_DEPTH, _RGB = 8, 2
_numbers = itertools.count(1)

#: Of a frame, or of several; they are sent in turn.
Part = bytes | memoryview


def to_frame(*payload: Part, binary: bool = False) -> list[Part]:
    """
    Return a frame of a server, which is not masked (RFC 6455, section 5.2).

    :param payload: its parts, which are joined where they are small.
    """
    opcode, size = _BINARY if binary else _TEXT, sum(map(len, payload))
    if size < 126:
        head = bytes((opcode, size))
    elif size < 1 << 16:
        head = struct.pack('>BBH', opcode, 126, size)
    else:
        head = struct.pack('>BBQ', opcode, 127, size)
    return [head, *payload] if size > _SMALL else [b''.join((head, *payload))]


def text_frames(message: Any, fragment_size: int = 0, compression: str = 'none') -> list[Part]:
    """
    Return the frames of a message in JSON, as a picture where ``compression`` is png.

    :param fragment_size: characters of a fragment; 0 for a single frame.
    """
    parts = list(json_pieces(message))
    if compression == 'png':
        parts = [to_json({'op': 'png', 'data': to_png(''.join(parts))})]
    if not fragment_size or sum(map(len, parts)) <= fragment_size:
        return to_frame(*(part.encode() for part in parts))
    text, number = ''.join(parts), next(_numbers)
    starts = range(0, len(text), fragment_size)
    return [part for index, start in enumerate(starts) for part in to_frame(to_json({
        'op': 'fragment', 'id': str(number), 'data': text[start:start + fragment_size],
        'num': index, 'total': len(starts)}).encode())]


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


class Fragments:
    """
    Joins the fragments that a client sends, in any order.

    :param patience: how long a message may stay incomplete [s].
    """

    def __init__(self, patience: float) -> None:
        self._patience = patience
        #: Id -> when it began, how many there are, and those that have come.
        self._known: dict[Any, tuple[float, int, dict[int, str]]] = {}
        self._size = 0

    def add(self, key: Any, data: str, number: int, total: int, now: float) -> str | None:
        """
        Take a fragment.

        :param now: [s].
        :returns: the whole text once all are there, else None.
        :raises RefusalError: the fragments do not fit together, or there are too many.
        """
        for late in [old for old, (since, *_) in self._known.items()
                     if now - since > self._patience]:
            self._forget(late)
        _, known_total, parts = self._known.get(key, (now, total, {}))
        if total < 1 or not 0 <= number < total or known_total != total:
            self._forget(key)
            raise RefusalError(f'num {number} of total {total}; num is 0 to total - 1, and total '
                               'is the same in all fragments of an id')
        size = self._size + len(data) - len(parts.get(number, ''))
        if size > MOST_BYTES or (key not in self._known and len(self._known) >= MOST_FRAGMENTED):
            self._forget(key)
            raise RefusalError(f'dropped; at most {MOST_BYTES} bytes of {MOST_FRAGMENTED} messages'
                               ' may be incomplete')
        self._size = size
        parts[number] = data
        self._known.setdefault(key, (now, total, parts))
        if len(parts) < total:
            return None
        self._forget(key)
        return ''.join(parts[index] for index in range(total))

    def _forget(self, key: Any) -> None:
        _, _, parts = self._known.pop(key, (0.0, 0, {}))
        self._size -= sum(map(len, parts.values()))


class _PatientDecoder(json.JSONDecoder):
    """A decoder whose loops are Python's, but for numbers and short objects in lists."""

    def __init__(self) -> None:
        super().__init__()
        quick: Any = self.scan_once  # type: ignore[has-type] # of C, set by the base class
        self.parse_array = lambda start, scan: JSONArray(start, lambda text, at: (
            quick if _SHORT.match(text, at, at + _SOON) else scan)(text, at))
        self.scan_once = py_make_scanner(self)


_PATIENT = _PatientDecoder()


def parse(frame: str | bytes) -> dict[str, Any]:
    """
    Return the object in a frame.

    :raises RefusalError: it is not a JSON object, or nested too deeply.
    """
    try:
        text = frame if isinstance(frame, str) else frame.decode()
        found = json.loads(text) if len(text) < _LONG else _PATIENT.decode(text)
    except json.JSONDecodeError as error:
        raise RefusalError(f'not JSON: {error.msg} at character {error.pos}') from None
    except UnicodeDecodeError as error:
        raise RefusalError(f'not UTF-8 at byte {error.start}') from None
    except RecursionError:
        raise RefusalError(_TOO_DEEP) from None
    except ValueError as error:
        raise RefusalError(f'not JSON: {error}') from None
    if not isinstance(found, dict):
        raise RefusalError(f'a message is a JSON object with "op", not {type(found).__name__}')
    if text.count('{') + text.count('[') > DEEPEST and _is_deep(found):
        raise RefusalError(_TOO_DEEP)
    return found


#: Levels of objects and lists in a message.
DEEPEST = 100
_TOO_DEEP = f'nested too deeply: at most {DEEPEST} levels'


def _is_deep(found: Any) -> bool:
    level = [found]
    for _ in range(DEEPEST):
        level = [item for value in level for item in _items(value)
                 if isinstance(item, (dict, list))]
        if not level:
            return False
    return True


def _items(value: Any) -> Iterator[Any]:
    return iter(value.values() if isinstance(value, dict) else value)
