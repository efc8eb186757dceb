# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Commands of the control rate as references at the rate of the physics."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Mask = NDArray[np.bool_]


class CommandInterpolator:
    """
    Splines through the position commands of successive control periods.

    A segment runs from the last command to the new one. It is quintic where velocities and
    accelerations are known at both ends, else cubic; a velocity that is not given is the
    difference of the two commands. With one step a period the command itself is the reference.

    :param positions: (n,) where the joints are [rad or m].
    """

    def __init__(self, positions: Vector) -> None:
        """Start at rest at the given positions."""
        count = len(positions)
        self._end = positions.copy()
        self._end_velocity = np.zeros(count)
        self._end_acceleration = np.zeros(count)
        self._coefficients: Vector | None = None
        self._steps, self._step = 1, 1

    def restart(self, positions: Vector, which: Mask) -> None:
        """
        Forget the commands of some joints and let them rest.

        :param positions: (n,) where they rest; entries of other joints are not read.
        :param which: (n,) the joints that are meant.
        """
        self._end = np.where(which, positions, self._end)
        self._end_velocity = np.where(which, 0.0, self._end_velocity)
        self._end_acceleration = np.where(which, 0.0, self._end_acceleration)
        if self._coefficients is not None:
            self._coefficients[:, which] = 0.0
            self._coefficients[0, which] = positions[which]

    def command(
        self, target: Vector, velocity: Vector, acceleration: Vector, steps: int, period: float
    ) -> None:
        """
        Take the command of one control period.

        :param target: (n,) where to be at its end [rad or m].
        :param velocity: (n,) at its end, NaN where not known [rad/s or m/s].
        :param acceleration: (n,) at its end, NaN where not known [rad/s^2 or m/s^2].
        :param steps: physics steps in the period.
        :param period: time of the period [s].
        """
        self._steps, self._step = steps, 0
        if steps == 1:
            self._end = target.copy()
            self._end_velocity = np.zeros_like(target)
            self._end_acceleration = np.full_like(target, np.nan)
            self._coefficients = None
            return
        distance = target - self._end
        end_velocity = np.where(np.isfinite(velocity), velocity, distance / period)
        self._coefficients = _segment(
            self._end,
            distance,
            self._end_velocity * period,
            end_velocity * period,
            self._end_acceleration * period**2,
            acceleration * period**2,
        )
        self._end = target.copy()
        self._end_velocity, self._end_acceleration = end_velocity, acceleration.copy()

    def advance(self) -> Vector:
        """Return the reference (n,) one physics step later; past the end it stays there."""
        self._step += 1
        if self._coefficients is None or self._step >= self._steps:
            return self._end
        s = self._step / self._steps
        value: Vector = self._coefficients[5]
        for power in (4, 3, 2, 1, 0):
            value = value * s + self._coefficients[power]
        return value


def _segment(p0: Vector, d: Vector, v0: Vector, v1: Vector, a0: Vector, a1: Vector) -> Vector:
    """
    Return polynomial coefficients (6, n) over s in 0..1.

    Quintic Hermite where both accelerations are finite, else cubic Hermite; derivatives are by
    s.
    """
    quintic = np.isfinite(a0) & np.isfinite(a1)
    a0, a1 = np.where(quintic, a0, 0.0), np.where(quintic, a1, 0.0)
    zero = np.zeros_like(p0)
    cubic_form = np.stack([p0, v0, 3 * d - 2 * v0 - v1, v0 + v1 - 2 * d, zero, zero])
    quintic_form = np.stack(
        [
            p0,
            v0,
            0.5 * a0,
            10 * d - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1,
            -15 * d + 8 * v0 + 7 * v1 + 1.5 * a0 - a1,
            6 * d - 3 * (v0 + v1) - 0.5 * a0 + 0.5 * a1,
        ]
    )
    return np.where(quintic, quintic_form, cubic_form)
