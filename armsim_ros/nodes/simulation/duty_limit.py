# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A limit on the processor time of a thread with real-time priority."""

from __future__ import annotations

import time


class DutyLimit:
    """
    Keeps a flooded real-time thread from starving other programs.

    :param share: of the time that the thread may compute.
    :param window: over which the share is measured [s].
    """

    def __init__(self, share: float = 0.8, window: float = 0.1) -> None:
        """Start counting in the thread that calls ``rest``."""
        self._share = share
        self._window = window
        self._begin = self._used = 0.0

    def rest(self) -> None:
        """Sleep until the thread is down to its share."""
        elapsed = time.monotonic() - self._begin
        if elapsed < self._window:
            return
        used = time.thread_time() - self._used
        if elapsed < 2.0 * self._window and used > self._share * elapsed:
            time.sleep(used / self._share - elapsed)
        self._begin, self._used = time.monotonic(), time.thread_time()
