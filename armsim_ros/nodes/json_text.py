# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""JSON text that browsers read."""

from __future__ import annotations

from binascii import b2a_base64
from collections.abc import Iterator
import json
import math
import secrets
from typing import Any

#: Replaces what is encoded in pieces until the text is complete; no text of a message has it.
_MARK = f'"{secrets.token_hex(16)}"'
#: Bytes are encoded in pieces, so that other threads do not wait; a multiple of three.
_PIECE = 3 << 16


class LongList:
    """
    A list that is made and encoded in pieces, so that other threads do not wait.

    :param size: number of items.
    :param pieces: the items, as short lists; they are read once.
    """

    def __init__(self, size: int, pieces: Iterator[list[Any]]) -> None:
        self.size, self.pieces = size, pieces


def to_json(value: Any) -> str:
    """
    Return JSON text without blanks.

    A number that is not finite becomes null, a memoryview of bytes base64.
    """
    return ''.join(json_pieces(value))


def json_pieces(value: Any) -> Iterator[str]:
    """Yield the text of :func:`to_json` in pieces, several where the value has long parts."""
    parts: list[Any] = []

    def keep(item: Any) -> str:
        if not isinstance(item, (memoryview, LongList)):
            raise TypeError(f'{type(item).__name__} is not a value of JSON')
        parts.append(item)
        return _MARK[1:-1]

    def dumps(value: Any) -> str:
        return json.dumps(value, allow_nan=False, separators=(',', ':'), default=keep)

    try:
        text = dumps(value)
    except ValueError:
        parts.clear()
        text = dumps(_finite(value))
    first, *others = text.split(_MARK) if parts else (text,)
    yield first
    for part, other in zip(parts, others, strict=True):
        yield from _base64(part) if isinstance(part, memoryview) else _items(part)
        yield other


def _base64(view: memoryview) -> Iterator[str]:
    yield '"'
    for start in range(0, len(view), _PIECE):
        yield b2a_base64(view[start:start + _PIECE], newline=False).decode('ascii')
    yield '"'


def _items(long: LongList) -> Iterator[str]:
    separator = '['
    for piece in long.pieces:
        texts = list(json_pieces(piece))
        texts[0] = separator + texts[0].removeprefix('[')
        texts[-1] = texts[-1].removesuffix(']')
        separator = ','
        yield from texts
    yield ']'


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    return value
