# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What large frames of clients hold is read in threads, so that other clients do not wait."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextvars import ContextVar
from typing import Any, TypeVar

from rclpy.serialization import deserialize_message

from armsim_ros.nodes.bridge.conversion.incoming import Now, serialized

#: From this size on a frame is large [bytes].
LARGE = 1 << 18
#: Large frames that are read at the same time.
_THREADS = ThreadPoolExecutor(4, 'decoding')
#: Of the frame that is being served; tasks that it starts inherit it.
_is_large = ContextVar('_is_large', default=False)

T = TypeVar('T')


async def aside(size: int, work: Callable[..., T], *values: Any) -> T:
    """
    Do what begins a frame, and note its size for what follows.

    :param size: [bytes].
    """
    _is_large.set(size >= LARGE)
    return await _run(work, *values)


async def message_of(cls: type[Any], values: Any, now: Now) -> Any:
    """
    Make a message.

    :raises ConversionError: a field is unknown, or a value does not fit.
    """
    return deserialize_message(await serialized_of(cls, values, now), cls)


async def serialized_of(cls: type[Any], values: Any, now: Now) -> bytes:
    """
    Make a serialized message as :func:`serialized` does.

    :raises ConversionError: a field is unknown, or a value does not fit.
    """
    if not _is_large.get():
        return serialized(cls, values, now)
    stamp = now()  # in this thread
    return await _run(serialized, cls, values, lambda: stamp)


async def _run(work: Callable[..., T], *values: Any) -> T:
    if not _is_large.get():
        return work(*values)
    return await asyncio.get_running_loop().run_in_executor(_THREADS, work, *values)
