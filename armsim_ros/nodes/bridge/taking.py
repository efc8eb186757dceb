# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Serialized messages from their subscriptions.

rclpy's own function copies a message twice while it holds all other threads up: for a tenth of a
second where it has 50 MB. The same function of rcl, called by ctypes, lets them run.
"""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any

import numpy as np

#: From this size on a message is copied by numpy, which lets other threads run [bytes].
_LARGE = 1 << 20
_OK, _NOTHING = 0, 401
_Pointer = ctypes.c_void_p


class _Allocator(ctypes.Structure):
    """``rcutils_allocator_t``."""

    _fields_ = tuple((name, _Pointer) for name in (
        'allocate', 'deallocate', 'reallocate', 'zero_allocate', 'state'))


class _Bytes(ctypes.Structure):
    """``rcutils_uint8_array_t``."""

    _fields_ = (('buffer', _Pointer), ('length', ctypes.c_size_t), ('capacity', ctypes.c_size_t),
                ('allocator', _Allocator))


@cache
def _libraries() -> tuple[Any, Any]:
    """Return rcl and rcutils, which rclpy has loaded."""
    rcl, rcutils = ctypes.CDLL('librcl.so'), ctypes.CDLL('librcutils.so')
    rcl.rcl_take_serialized_message.argtypes = [_Pointer, ctypes.POINTER(_Bytes), _Pointer,
                                                _Pointer]
    rcutils.rcutils_get_default_allocator.restype = _Allocator
    return rcl, rcutils


def take(handle: Any) -> bytes | memoryview | None:
    """
    Return the next message of a subscription, None where there is none.

    :param handle: of the subscription; it stays alive meanwhile.
    :raises RuntimeError: the middleware failed.
    """
    rcl, rcutils = _libraries()
    found = _Bytes(allocator=rcutils.rcutils_get_default_allocator())
    status = rcl.rcl_take_serialized_message(handle.pointer, ctypes.byref(found), None, None)
    try:
        if status == _NOTHING:
            return None
        if status != _OK:
            raise RuntimeError(f'rcl_take_serialized_message failed with {status}')
        if found.length < _LARGE:
            return ctypes.string_at(found.buffer, found.length)
        place = ctypes.cast(found.buffer, ctypes.POINTER(ctypes.c_uint8))
        return np.ctypeslib.as_array(place, (found.length,)).copy().data
    finally:
        if status != _OK:
            rcutils.rcutils_reset_error()
        rcutils.rcutils_uint8_array_fini(ctypes.byref(found))
