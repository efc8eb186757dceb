# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Warns once when simulated time and the wall clock diverge."""

from __future__ import annotations

from collections.abc import Callable
import time

from armsim_ros.sim.clock import SimClock

#: From this difference on, stamps of the two clocks no longer pass as the same time [ns].
TOLERANCE_NS = 500_000_000


class ClockHint:
    """
    Compares the clocks and names the remedy once they differ.

    :param clock: simulated time, which started at the wall clock's.
    :param warn: takes the text.
    """

    def __init__(self, clock: SimClock, warn: Callable[[str], object]) -> None:
        self._clock = clock
        self._warn = warn
        self._said = False

    def look(self) -> None:
        """Compare once."""
        if self._said:
            return
        behind = self._clock.behind_ns(time.time_ns())
        if abs(behind) > TOLERANCE_NS:
            self._said = True
            side = 'behind' if behind > 0 else 'ahead of'
            self._warn(
                f'simulated time is now {abs(behind) / 1e9:.1f} s {side} the wall clock; programs '
                'that take stamps from the wall clock no longer agree with it: start them '
                'with the parameter use_sim_time:=true'
            )
