# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Stops the code of a launch file that does not come to an end."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import os
import signal
import sys
import threading
import time
from types import FrameType

from armsim_ros.errors import Location, USAGE_STATUS
from armsim_ros.launch.api.entity import calling_place
from armsim_ros.launch.failures import StoppedError

#: Processor time that a launch file's code may take without a break [s].
LONGEST_EVALUATION = 30.0
#: Factor by which it may take longer in wall time, waiting or on a busy machine.
_PATIENCE = 4.0
#: How often code that catches everything is interrupted before the process ends.
_TRIES = 5


@contextmanager
def watchdog(seconds: float = LONGEST_EVALUATION) -> Iterator[None]:
    """
    Limit the time of the code inside.

    :param seconds: of processor time; four times as much of wall time [s].
    :raises StoppedError: in the code that runs then, with its line.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    tries = 0
    used, begun = time.process_time(), time.monotonic()

    def stop(_number: int, frame: FrameType | None) -> None:
        nonlocal tries
        if (time.process_time() - used < 0.9 * seconds
                and time.monotonic() - begun < _PATIENCE * seconds):
            return
        tries += 1
        place = _place(frame)
        text = (f'{place}: the launch file does not come to an end; stopped after '
                f'{time.monotonic() - begun:.1f} s')
        if tries > _TRIES:
            print(f'launch: {text}', file=sys.stderr, flush=True)
            os._exit(USAGE_STATUS)
        raise StoppedError(text)

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds, min(1.0, seconds))
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def _place(frame: FrameType | None) -> Location | None:
    inner = frame
    while inner is not None:
        name = inner.f_code.co_filename
        if not name.startswith('<') and 'armsim_ros' + os.sep + 'launch' not in name \
                and not name.startswith(os.path.dirname(os.__file__)):
            return Location(name, inner.f_lineno)
        inner = inner.f_back
    return calling_place()
