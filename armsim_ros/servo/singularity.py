# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How near an arm is to a singularity, and how much slower that makes it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.servo.status import Finding, ServoStatus

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
