# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""SIGINT and SIGTERM as a wish that a program looks at when it can."""

from __future__ import annotations

from collections.abc import Callable
import signal
from types import FrameType


class StopSignals:
    """SIGINT and SIGTERM as a wish that is looked at between the steps of the start."""

    def __init__(self) -> None:
        """Take the signals over."""
        self.wanted = False
        self.on_stop: Callable[[], None] | None = None
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._receive)

    def _receive(self, _number: int, _frame: FrameType | None) -> None:
        self.wanted = True
        if self.on_stop is not None:
            self.on_stop()
