# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Ends a test that takes too long by the wall clock."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import signal
import threading
from typing import Any, TYPE_CHECKING

if TYPE_CHECKING:
    from armsim_ros.testing.arms.arm import Arm


@contextmanager
def wall_time_limit(seconds: float, arm: Arm) -> Iterator[None]:
    """
    Raise an AssertionError with the arm's state in the test when the time is over.

    Works in the main thread, where tests run. An alarm that was set elsewhere, such as
    pytest-timeout, is left alone and replaces this limit.

    :param seconds: [s].
    """
    if (threading.current_thread() is not threading.main_thread()
            or signal.getsignal(signal.SIGALRM) is not signal.SIG_DFL):
        yield
        return

    def end(*_: Any) -> None:
        raise AssertionError(
            f'the test took more than {seconds:g} s of wall time; {arm.summary()}')

    signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
