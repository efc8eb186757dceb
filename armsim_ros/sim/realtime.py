# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the operating system and the interpreter can do for a thread that must be on time."""

from __future__ import annotations

import ctypes
import gc
import os
import sys

#: Time after which a thread that computes in Python yields [s]; the default is 5 ms.
SWITCH_INTERVAL = 1e-4
_PR_SET_TIMERSLACK = 29


def prefer_latency() -> None:
    """
    Make the process quick to answer; call it once, after everything is loaded.

    Threads yield sooner, and what exists now is no longer visited by the garbage collector.
    """
    sys.setswitchinterval(SWITCH_INTERVAL)
    gc.collect()
    gc.freeze()


def prioritize_thread(priority: int) -> bool:
    """
    Ask for SCHED_FIFO and exact timers for the calling thread.

    :param priority: 1 to 99; 0 asks for exact timers alone.
    :returns: whether the thread has the priority; without the permission it goes on as it was.
    """
    if not sys.platform.startswith('linux'):
        return False
    ctypes.CDLL(None).prctl(_PR_SET_TIMERSLACK, ctypes.c_ulong(1000), 0, 0, 0)
    if priority <= 0:
        return False
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except OSError:
        return False
    return True
