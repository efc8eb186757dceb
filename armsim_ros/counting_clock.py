# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A clock that makes planning repeatable."""

from __future__ import annotations

#: Time that passes at each look [s].
TICK = 1e-4


class CountingClock:
    """
    A clock that counts how often it is read.

    A planner that takes its time from it does the same work on every machine and at any load.
    """

    def __init__(self) -> None:
        self._looks = 0

    def __call__(self) -> float:
        """Return the time [s]; it is later each time."""
        self._looks += 1
        return self._looks * TICK
