# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Velocities kept within what joints can do and may do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.servo.status import Finding, ServoStatus

AT_BOUND = 1e-3
"""From here on a joint counts as having come to its bound [rad or m]."""


@dataclass(frozen=True, slots=True, eq=False)
class JointBounds:
    """
    Bounds of m joints.

    :param lower: (m,) margins taken off [rad or m].
    :param upper: (m,) margins taken off [rad or m].
    :param velocity: (m,) [rad/s or m/s].
    :param acceleration: (m,) [rad/s^2 or m/s^2].
    """

    names: tuple[str, ...]
    lower: Vector
    upper: Vector
    velocity: Vector
    acceleration: Vector

    def limit_speed(self, velocity: Vector, override: float) -> Vector:
        """
        Return velocities (m,) that no joint's limit forbids; a common factor.

        :param override: factor of all velocities; below 0.01 it is off. The limits may make the
            common factor smaller.
        """
        excess = _greatest(np.abs(velocity) / self.velocity)
        factor = min(override if override >= 0.01 else 1.0, 1.0 / max(excess, 1.0))
        return velocity * factor if factor < 1.0 else velocity

    def limit_position(
        self, q: Vector, velocity: Vector, period: float, *, all_halt: bool
    ) -> tuple[Vector, Finding | None]:
        """
        Return velocities (m,) from which every joint can brake before its bound.

        :param q: (m,) positions [rad or m].
        :param all_halt: slow all joints as the joint at its bound, not that joint alone.
        :returns: the velocities, and findings where a joint has come to its bound.
        """
        distance, fastest = self._fastest(q, velocity, period)
        speed = np.abs(velocity)
        too_fast = speed > fastest
        if not too_fast.any():
            return velocity, None
        halted = np.flatnonzero(too_fast & (distance < AT_BOUND))
        finding = None
        if len(halted):
            joint = int(halted[0])
            bound = self.upper[joint] if velocity[joint] > 0.0 else self.lower[joint]
            finding = Finding(
                ServoStatus.JOINT_BOUND,
                f"joint '{self.names[joint]}' at {q[joint]:.4f}, allowed up to {bound:.4f}",
            )
        if not all_halt:
            return np.copysign(np.minimum(speed, fastest), velocity), finding
        share = float(np.min(fastest[too_fast] / speed[too_fast]))
        return velocity * share, finding

    def accelerate(self, now: Vector, requested: Vector, period: float) -> Vector:
        """Return the velocities (m,) a cycle later; all joints approach by a common factor."""
        change = requested - now
        excess = _greatest(np.abs(change) / (self.acceleration * period))
        return now + change / excess if excess > 1.0 else requested

    def brake_in_time(self, q: Vector, now: Vector, velocity: Vector, period: float) -> Vector:
        """
        Return velocities (m,) of which none leads a joint past its bound.

        A joint that comes near its bound brakes as hard as it may, even where all others, and
        by that the common factor, are slower to change.

        :param q: (m,) positions [rad or m].
        :param now: (m,) velocities before [rad/s or m/s].
        :param velocity: (m,) those of the next cycle.
        """
        _, fastest = self._fastest(q, velocity, period)
        least = np.where(now * velocity > 0.0, np.abs(now) - self.acceleration * period, 0.0)
        return np.copysign(np.minimum(np.abs(velocity), np.maximum(fastest, least)), velocity)

    def _fastest(self, q: Vector, velocity: Vector, period: float) -> tuple[Vector, Vector]:
        """Return the distance to the bounds ahead (m,), and speeds that can be braked in it."""
        distance = np.maximum(np.where(velocity > 0.0, self.upper - q, q - self.lower), 0.0)
        braked = np.sqrt(2.0 * self.acceleration * distance)
        return distance, np.minimum(braked, distance / period)

    def braking_time(self, velocity: Vector) -> float:
        """Return how long the joints take to come to rest together [s]."""
        return _greatest(np.abs(velocity) / self.acceleration)


def _greatest(values: Vector) -> float:
    """Return the greatest of values that are not negative, 0 of none."""
    return float(np.maximum.reduce(values, initial=0.0))
