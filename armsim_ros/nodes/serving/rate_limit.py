# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How quickly a connection is read: what comes faster waits at its sender."""

from __future__ import annotations


class RateLimit:
    """
    A bucket that fills with time and empties with use.

    :param burst: units that may come at once.
    :param rate: units per second after that.
    """

    def __init__(self, burst: float, rate: float) -> None:
        self._burst, self._rate = burst, rate
        self._left, self._since = burst, 0.0

    def delay(self, now: float, amount: float = 1.0) -> float:
        """
        Count what has come and return how long to wait before reading on.

        :param now: [s], of any clock.
        :param amount: units.
        :returns: [s], 0 where the limit is kept.
        """
        filled = self._left + self._rate * max(0.0, now - self._since)
        self._left, self._since = min(self._burst, filled) - amount, now
        return max(0.0, -self._left / self._rate)
