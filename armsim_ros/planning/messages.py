# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Objects through a pipe between two processes of this package."""

from __future__ import annotations

import io
import os
import pickle
import select
import struct
from types import MappingProxyType
from typing import Any

_LENGTH = struct.Struct('<Q')


def encoded(message: object) -> bytes:
    """Return the bytes of a message; read-only mappings may be in it."""
    content = io.BytesIO()
    pickler = pickle.Pickler(content, pickle.HIGHEST_PROTOCOL)
    pickler.dispatch_table = {MappingProxyType: lambda mapping: (_read_only, (dict(mapping),))}
    pickler.dump(message)
    return _LENGTH.pack(content.tell()) + content.getvalue()


def readable(file: int, seconds: float = 0.0) -> bool:
    """Return whether there is something to read within a time [s], the end among it."""
    poll = select.poll()
    poll.register(file, select.POLLIN)
    return bool(poll.poll(1e3 * seconds))


def send(file: int, message: object) -> None:
    """Write a message; BrokenPipeError where nobody reads any more."""
    content = memoryview(encoded(message))
    while content:
        content = content[os.write(file, content):]


def received(file: int) -> Any:
    """Return the next message, waiting for it; None at the end."""
    head = _exactly(file, _LENGTH.size)
    if head is None:
        return None
    content = _exactly(file, _LENGTH.unpack(head)[0])
    return None if content is None else pickle.loads(content)


def _read_only(mapping: dict[Any, Any]) -> MappingProxyType[Any, Any]:
    return MappingProxyType(mapping)


def _exactly(file: int, count: int) -> bytes | None:
    parts = []
    while count:
        part = os.read(file, min(count, 1 << 20))
        if not part:
            return None
        parts.append(part)
        count -= len(part)
    return b''.join(parts)
