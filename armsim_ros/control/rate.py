# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Things that happen at a rate of simulated time."""

from __future__ import annotations

import math

TOLERANCE_NS = 1_000
"""So much too early still counts as in time: rounding of float time steps [ns]."""


class Rate:
    """
    Determines when something is due: at multiples of the period after the first time asked.

    :param frequency: [Hz]; infinite is always, 0 or less is never.
    :param aligned: count the multiples from time 0 instead, so that what has the same rate is
        due at the same time; the first time asked it is due all the same.
    """

    def __init__(self, frequency: float, *, aligned: bool = False) -> None:
        self._period_ns = 1e9 / frequency if frequency > 0.0 else math.inf
        self._aligned = aligned and self._period_ns > 0.0
        self._base_ns = 0
        self._count = 0
        self._last_ns: int | None = None

    def next_due_ns(self, time_ns: int) -> int | None:
        """Return when it is due next, from a time on [ns]; None where it is never."""
        if math.isinf(self._period_ns):
            return None
        last = self._last_ns
        if last is None or time_ns < last or self._period_ns == 0.0:
            return time_ns
        return math.ceil(self._base_ns + (self._count + 1) * self._period_ns) - TOLERANCE_NS

    def due(self, time_ns: int) -> bool:
        """
        Return whether it is time again; asked once an update [ns].

        Periods that were missed are not made up for; when time jumps back it starts anew.
        """
        if math.isinf(self._period_ns):
            return False
        last, self._last_ns = self._last_ns, time_ns
        if last is None or time_ns < last:
            since_ns = time_ns % self._period_ns if self._aligned else 0.0
            self._base_ns, self._count = time_ns - round(since_ns), 0
            return True
        if self._period_ns == 0.0:
            return time_ns > last
        count = int((time_ns + TOLERANCE_NS - self._base_ns) // self._period_ns)
        if count > self._count:
            self._count = count
            return True
        return False
