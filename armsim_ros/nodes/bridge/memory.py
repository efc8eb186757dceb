# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Memory that many clients needed at once goes back to the system."""

from __future__ import annotations

import ctypes
import gc


def give_back() -> None:
    """
    Return what is not used to the system.

    The C library keeps what was freed; glibc's has a function that returns it, others need none.
    """
    gc.collect()
    trim = getattr(ctypes.CDLL(None), 'malloc_trim', None)
    if trim is not None:
        trim(0)
