# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""JSON text that browsers read."""

from __future__ import annotations

from binascii import b2a_base64
import json
import math
import secrets
from typing import Any

#: Replaces bytes until the text is complete; no text of a message can contain it.
_MARK = secrets.token_hex(16)
#: Bytes are encoded in pieces, so that other threads do not wait; a multiple of three.
_PIECE = 3 << 16


def to_json(value: Any) -> str:
    """
    Return JSON text without blanks.

    A number that is not finite becomes null, a memoryview of bytes base64.
    """
    views: list[memoryview] = []

    def keep(item: Any) -> str:
        if not isinstance(item, memoryview):
            raise TypeError(f'{type(item).__name__} is not a value of JSON')
        views.append(item)
        return _MARK

    def dumps(value: Any) -> str:
        return json.dumps(value, allow_nan=False, separators=(',', ':'), default=keep)

    try:
        text = dumps(value)
    except ValueError:
        views.clear()
        text = dumps(_finite(value))
    if not views:
        return text
    first, *others = text.split(_MARK)
    parts = [first]
    for view, other in zip(views, others, strict=True):
        parts += [*(b2a_base64(view[start:start + _PIECE], newline=False).decode('ascii')
                    for start in range(0, len(view), _PIECE)), other]
    return ''.join(parts)


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    return value
