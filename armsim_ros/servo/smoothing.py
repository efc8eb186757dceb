# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Filters between the streamed positions and what is sent."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
import math
from typing import Any

import numpy as np

from armsim_ros.arrays import Vector

ARRIVED = 1e-4
"""Nearer to an input that rests, an output need not approach it any longer [rad or m]."""


class SmoothingFilter(ABC):
    """Smooths the positions of n joints, cycle by cycle."""

    @abstractmethod
    def restart(self, positions: Vector) -> None:
        """Rest at positions (n,) [rad or m]."""

    @abstractmethod
    def smooth(self, positions: Vector) -> Vector:
        """Return the positions (n,) to send for those requested [rad or m]."""

    @abstractmethod
    def saved(self) -> Any:
        """Return what it remembers."""

    @abstractmethod
    def restore(self, saved: Any) -> None:
        """Remember what ``saved`` has returned."""


class NoFilter(SmoothingFilter):
    """Passes positions through."""

    def restart(self, positions: Vector) -> None:
        """Do nothing."""

    def smooth(self, positions: Vector) -> Vector:
        """Return the positions themselves."""
        return positions

    def saved(self) -> None:
        """Return nothing."""

    def restore(self, saved: None) -> None:
        """Do nothing."""


class ButterworthFilter(SmoothingFilter):
    """
    First-order low pass: ``y = (x0 + x1 - (1 - k) y1) / (1 + k)``; it arrives where x rests.

    :param coefficient: k, greater than 1; greater is smoother and later.
    """

    def __init__(self, coefficient: float) -> None:
        """Keep the coefficient."""
        self._k = coefficient
        self._last_input = self._last_output = np.zeros(0)

    def restart(self, positions: Vector) -> None:
        """Rest at positions."""
        self._last_input = self._last_output = positions

    def smooth(self, positions: Vector) -> Vector:
        """Return the next output."""
        rest = positions + self._last_input - 2.0 * self._last_output
        output: Vector = self._last_output + rest / (1.0 + self._k)
        arrived = (positions == self._last_input) & (np.abs(positions - output) < ARRIVED)
        output = np.where(arrived, positions, output)
        self._last_input, self._last_output = positions, output
        return output

    def saved(self) -> tuple[Vector, Vector]:
        """Return the last input and output."""
        return self._last_input, self._last_output

    def restore(self, saved: tuple[Vector, Vector]) -> None:
        """Take the last input and output."""
        self._last_input, self._last_output = saved


class AccelerationFilter(SmoothingFilter):
    """
    Follows with bounded velocity and acceleration.

    What keeps the bounds is passed on as it is, without a lag. Where the input has gone ahead,
    each cycle reduces the distance to it as far as the bounds allow and still let it end with
    the input's velocity; where they do not, it brakes.

    :param velocity: (n,) infinite where there is no limit [rad/s or m/s].
    :param acceleration: (n,) [rad/s^2 or m/s^2].
    :param period: of a cycle [s].
    """

    def __init__(self, velocity: Vector, acceleration: Vector, period: float) -> None:
        """Keep the bounds."""
        self._fastest = velocity
        self._change = acceleration * period
        self._acceleration, self._period = acceleration, period
        self.restart(np.zeros(len(velocity)))

    def restart(self, positions: Vector) -> None:
        """Rest at positions."""
        self._last_input = self._position = positions
        self._velocity = np.zeros_like(positions)

    def smooth(self, positions: Vector) -> Vector:
        """Return the next output."""
        distance = self._last_input - self._position
        way = np.abs(distance)
        # From v it comes to rest in v * T + (v - a * T) * T + ..., that is v^2 / 2a + v * T / 2.
        half = 0.5 * self._change
        braking = np.sqrt(half * half + 2.0 * self._acceleration * way) - half
        approach = np.copysign(np.minimum(braking, way / self._period), distance)
        requested = np.clip((positions - self._last_input) / self._period + approach,
                            -self._fastest, self._fastest)
        self._velocity = np.clip(
            requested, self._velocity - self._change, self._velocity + self._change)
        self._last_input = positions
        self._position = self._position + self._velocity * self._period
        return self._position

    def saved(self) -> tuple[Vector, Vector, Vector]:
        """Return the last input, position and velocity."""
        return self._last_input, self._position, self._velocity

    def restore(self, saved: tuple[Vector, Vector, Vector]) -> None:
        """Take the last input, position and velocity."""
        self._last_input, self._position, self._velocity = saved


class JerkFilter(SmoothingFilter):
    """
    Follows with bounded velocity, acceleration and jerk.

    The mean of the last positions of an acceleration-limited motion: over a time of 2 a / j the
    acceleration can change by no more than j allows (L. Biagiotti, C. Melchiorri, "FIR filters
    for online trajectory planning with time- and frequency-domain specifications", 2012).

    :param acceleration: (n,) [rad/s^2 or m/s^2].
    :param jerk: (n,) [rad/s^3 or m/s^3].
    """

    def __init__(
        self, velocity: Vector, acceleration: Vector, jerk: Vector, period: float
    ) -> None:
        """Keep the bounds."""
        self._inner = AccelerationFilter(velocity, acceleration, period)
        count = math.ceil(float(np.max(2.0 * acceleration / jerk)) / period)
        self._past: deque[Vector] = deque(maxlen=max(1, count))
        self.restart(np.zeros(len(velocity)))

    def restart(self, positions: Vector) -> None:
        """Rest at positions."""
        self._inner.restart(positions)
        self._past.extend([positions] * (self._past.maxlen or 1))

    def smooth(self, positions: Vector) -> Vector:
        """Return the next output."""
        self._past.append(self._inner.smooth(positions))
        # Means of differences: what does not move is passed on as it is.
        newest = self._past[-1]
        mean: Vector = newest + np.mean([past - newest for past in self._past], axis=0)
        return mean

    def saved(self) -> tuple[tuple[Vector, Vector, Vector], tuple[Vector, ...]]:
        """Return what the inner filter remembers, and the last positions."""
        return self._inner.saved(), tuple(self._past)

    def restore(self, saved: tuple[tuple[Vector, Vector, Vector], tuple[Vector, ...]]) -> None:
        """Take what the inner filter remembers, and the last positions."""
        self._inner.restore(saved[0])
        self._past.extend(saved[1])
