# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A long control period at once: all that a cubic reference requires is linear in a few rows."""

from __future__ import annotations

import mujoco
import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.sim.drives.reference import DrivenLimits

#: From a cubic's factors to Bernstein's coefficients of its velocity, then of itself.
_BERNSTEIN = np.array([[0.0, 1.0, 0.0, 0.0], [0.0, 1.0, 1.0, 0.0], [0.0, 1.0, 2.0, 3.0],
                       [1.0, 1 / 3, 0.0, 0.0], [1.0, 2 / 3, 1 / 3, 0.0], [1.0, 1.0, 1.0, 1.0]])


class PeriodBasis:
    """
    What the steps of a period make of its features.

    Features are rows (5, n): the reference at its start, the factors of s, s^2 and s^3 with s from
    0 to 1 over the period, and the velocity before its first step. Velocities and accelerations
    are the differences of the references. All products are MuJoCo's: the bytes of numpy's differ
    between its versions.

    :param steps: physics steps in the period.
    :param timestep: of each [s].
    :param limits: of the joints.
    :param implicit: whether damping counts the velocity at a step's end, not at its start.
    """

    def __init__(
        self, steps: int, timestep: float, limits: DrivenLimits, *, implicit: bool
    ) -> None:
        self.steps = steps
        self._limits, self._timestep = limits, timestep
        self._longest_step = timestep * limits.velocity
        farthest = steps * timestep * limits.velocity
        #: Between these rows those of ``_BERNSTEIN`` are within the limits.
        self._least = np.stack((*[-farthest] * 3, *[limits.lower] * 3))
        self._most = np.stack((*[farthest] * 3, *[limits.upper] * 3))
        s = np.arange(steps + 1) / steps
        self._share = s[:-1]
        powers = np.stack((np.ones_like(s), s, s * s, s * s * s, np.zeros_like(s)), axis=1)
        velocities = np.empty_like(powers)
        velocities[0] = 0.0, 0.0, 0.0, 0.0, 1.0
        velocities[1:] = np.diff(powers, axis=0) / timestep
        self._accelerations = np.diff(velocities, axis=0) / timestep
        self._motion = np.concatenate((powers, velocities))
        damped = velocities[1:] if implicit else velocities[:-1]
        forced = self._accelerations[:, 1:]
        share = self._share[:, None]
        self._inputs = np.ascontiguousarray(np.concatenate(
            (forced, share * forced, powers[:-1, :4], damped[:, 1:], powers[:-1, :2]), axis=1))

    def motion(self, features: Matrix) -> tuple[Matrix, Matrix]:
        """Return references (k + 1, n) and velocities (k + 1, n) before each step, and after."""
        found = product(self._motion, features)
        return found[:self.steps + 1], found[self.steps + 1:]

    def allows(self, features: Matrix, references: Matrix, velocities: Matrix) -> bool:
        """Return whether a motion is within the limits."""
        # Bernstein's coefficients bound a polynomial; that is enough mostly.
        bounds = product(_BERNSTEIN, features[:4])
        if ((bounds >= self._least) & (bounds <= self._most)).all():
            return True
        limits = self._limits
        return bool((np.abs(velocities[1:]) * self._timestep <= self._longest_step).all()
                    and (references >= limits.lower).all()
                    and (references <= limits.upper).all())

    def accelerations(self, features: Matrix) -> Matrix:
        """Return the accelerations of each step (k, n)."""
        return product(self._accelerations, features)

    def inputs(
        self, features: Matrix, first: Matrix, change: Matrix, bias: Matrix, stiffness: Vector,
        damping: Vector,
    ) -> Matrix:
        """
        Return the actuators' inputs in each step (k, n).

        :param features: (5, n).
        :param first: (4, n) the features but the first, times the inertia at the start.
        :param change: (4, n) times the inertia at the end less that at the start.
        :param bias: (2, n) the other forces at the start, and their change.
        :param stiffness: (n,) of the actuators.
        :param damping: (n,) of the actuators.
        """
        return product(self._inputs, np.concatenate(
            (first, change, features[:4] * stiffness, features[1:] * damping, bias)))


def product(left: Matrix, right: Matrix) -> Matrix:
    """Return the product of two matrices, with the same bytes everywhere."""
    found = np.empty((left.shape[0], right.shape[1]))
    mujoco.mju_mulMatMat(found, np.ascontiguousarray(left), right)
    return found
