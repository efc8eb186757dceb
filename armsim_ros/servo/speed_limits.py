# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What slows a stream of commands: singularities and the bounds of joints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.servo.commands import Finding, ServoStatus

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
            bound, way = ((self.upper[joint], 'up') if velocity[joint] > 0.0
                          else (self.lower[joint], 'down'))
            finding = Finding(
                ServoStatus.JOINT_BOUND,
                f"joint '{self.names[joint]}' at {q[joint]:.4f}, allowed {way} to {bound:.4f}",
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


SLOWEST_WAY_OUT = 0.1
"""A motion away from a singularity keeps this share of its speed."""


@dataclass(frozen=True, slots=True)
class SingularityThresholds:
    """
    Condition numbers, see the parameters of servo.

    :param step: relative length of the step that finds the side of the singularity.
    """

    lower: float
    hard: float
    leaving: float
    step: float


def condition(jacobian: Matrix) -> tuple[float, Vector]:
    """Return greatest over smallest singular value, and the left vector (6,) of the smallest."""
    # Eigenvalues of J J^T are the squares of the singular values, in rising order.
    values, left = np.linalg.eigh(jacobian @ jacobian.T)
    place = max(0, 6 - jacobian.shape[1])
    smallest = float(values[place])
    if smallest <= 1e-14 * float(values[-1]):
        return math.inf, left[:, place]
    return math.sqrt(float(values[-1]) / smallest), left[:, place]


def surely_below(jacobian: Matrix, bound: float) -> bool:
    """
    Return True only where the condition number is not above a bound; quicker than to know it.

    Frobenius norms of a matrix and its inverse are no smaller than its greatest eigenvalue and
    the inverse of its smallest value.
    """
    few = jacobian.shape[1] < len(jacobian)
    squares = jacobian.T @ jacobian if few else jacobian @ jacobian.T
    try:
        inverse = np.linalg.inv(squares)
    except np.linalg.LinAlgError:
        return False
    return bool(np.vdot(squares, squares) * np.vdot(inverse, inverse) <= bound**4)


def singularity_factor(
    q: Vector,
    twist: Vector,
    jacobian: Matrix,
    jacobian_at: Callable[[Vector], Matrix],
    thresholds: SingularityThresholds,
) -> tuple[float, Finding | None]:
    """
    Return the share of a motion's speed that a singularity leaves.

    :param q: (m,) the moving joints [rad or m].
    :param twist: (6,) requested of the tip, linear over angular, in the units of the Jacobian.
    :param jacobian: (6, m) there.
    :param jacobian_at: (m,) -> (6, m), for other positions.
    :returns: 0 to 1, and findings where it is less than 1.
    """
    if surely_below(jacobian, thresholds.lower):
        return 1.0, None
    number, direction = condition(jacobian)
    if number <= thresholds.lower:
        return 1.0, None
    step = np.linalg.pinv(jacobian, rcond=1e-6) @ (direction * thresholds.step)
    length = float(np.abs(step).max())
    if length > 0.1:  # next to the singularity a step in the tip's space is long in the joints'
        step *= 0.1 / length
    if condition(jacobian_at(q + step))[0] < number:
        direction = -direction
    detail = f'condition number {number:.1f}, allowed {thresholds.hard:g}'
    span = thresholds.hard - thresholds.lower
    if float(direction @ twist) > 0.0:
        if number >= thresholds.hard:
            return 0.0, Finding(ServoStatus.HALT_FOR_SINGULARITY, detail)
        return 1.0 - (number - thresholds.lower) / span, Finding(
            ServoStatus.DECELERATE_FOR_APPROACHING_SINGULARITY, detail
        )
    factor = 1.0 - (number - thresholds.lower) / (span * thresholds.leaving)
    return max(factor, SLOWEST_WAY_OUT), Finding(
        ServoStatus.DECELERATE_FOR_LEAVING_SINGULARITY, detail
    )
