# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Polynomials between two states, and their derivatives by time.

A segment is a polynomial of degree 5 or less in ``u = (t - t0) / T``, 0 <= u <= 1, the highest
that both ends support: positions alone are joined by a line, with velocities by a cubic
(Hermite), with accelerations too by a quintic.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Matrix, Vector

DEGREE = 5
LINEAR, CUBIC, QUINTIC = 0, 1, 2


def hermite_coefficients(
    durations: Vector, levels: NDArray[np.int64], start: Matrix, end: Matrix
) -> Matrix:
    """
    Return the coefficients of k segments of n joints.

    :param durations: (k,) T of each segment, positive [s].
    :param levels: (k,) LINEAR, CUBIC or QUINTIC.
    :param start: (3, k, n) position, velocity, acceleration at the start; derivatives that the
        level does not use may be NaN.
    :param end: (3, k, n) the same at the end.
    :returns: (k, 6, n) in powers of u.
    """
    T = durations[:, None]
    p0, p1 = start[0], end[0]
    cubic = (levels >= CUBIC)[:, None]
    quintic = (levels >= QUINTIC)[:, None]
    v0, v1 = np.where(cubic, start[1], 0.0) * T, np.where(cubic, end[1], 0.0) * T
    a0, a1 = (np.where(quintic, x[2], 0.0) * (0.5 * T * T) for x in (start, end))
    d = p1 - p0
    joints = p0.shape[1]
    c = np.zeros((len(durations), DEGREE + 1, joints))
    c[:, 0] = p0
    c[:, 1] = np.where(cubic, v0, d)
    c[:, 2] = np.where(quintic, a0, np.where(cubic, 3.0 * d - 2.0 * v0 - v1, 0.0))
    c[:, 3] = np.where(
        quintic,
        10.0 * d - 6.0 * v0 - 4.0 * v1 - 3.0 * a0 + a1,
        np.where(cubic, v0 + v1 - 2.0 * d, 0.0),
    )
    c[:, 4] = np.where(quintic, -15.0 * d + 8.0 * v0 + 7.0 * v1 + 3.0 * a0 - 2.0 * a1, 0.0)
    c[:, 5] = np.where(quintic, 6.0 * d - 3.0 * (v0 + v1) - a0 + a1, 0.0)
    return c


def with_derivatives(position: Matrix, durations: Vector) -> Matrix:
    """
    Put the coefficients of velocity and acceleration beside those of the position.

    :param position: (k, 6, n) in powers of u.
    :param durations: (k,) [s].
    :returns: (k, 6, 3n).
    """
    joints = position.shape[2]
    full = np.zeros((*position.shape[:2], 3 * joints))
    powers = np.arange(1, DEGREE + 1)[None, :, None]
    rate = 1.0 / durations[:, None, None]
    full[:, :, :joints] = position
    full[:, :-1, joints : 2 * joints] = position[:, 1:] * powers * rate
    full[:, :-1, 2 * joints :] = full[:, 1:, joints : 2 * joints] * powers * rate
    return full


def powers(u: Vector) -> Matrix:
    """Return 1, u, .., u^5 as (m, 6) for u (m,)."""
    return u[:, None] ** np.arange(DEGREE + 1)
