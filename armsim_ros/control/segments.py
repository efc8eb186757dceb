# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Polynomials between waypoints.

A segment is a polynomial of degree 5 or less in ``u = (t - t0) / T``, 0 <= u <= 1. Its
coefficients and those of its first two derivatives by time stand side by side in one (6, 3n)
or, with effort, (6, 4n) matrix, so that one product with (1, u, .., u^5) gives the whole state.
The degree is the highest that both ends support: positions alone are joined by a line, with
velocities by a cubic (Hermite), with accelerations too by a quintic.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsim_ros.control.waypoints import Waypoints

Matrix = NDArray[np.float64]

DEGREE = 5
LINEAR, CUBIC, QUINTIC = 0, 1, 2


def spline_coefficients(
    durations: Matrix, levels: NDArray[np.int64], start: Matrix, end: Matrix
) -> Matrix:
    """
    Return the coefficients of k segments of n joints.

    :param durations: (k,) T of each segment, positive [s].
    :param levels: (k,) LINEAR, CUBIC or QUINTIC.
    :param start: (3, k, n) position, velocity, acceleration at the start; derivatives that the
        level does not use may be NaN.
    :param end: (3, k, n) the same at the end.
    :returns: (k, 6, 3n).
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
    return with_derivatives(c, durations)


def with_derivatives(position: Matrix, durations: Matrix) -> Matrix:
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


def with_effort(coefficients: Matrix, start: Matrix, end: Matrix) -> Matrix:
    """
    Put linear effort beside the motion.

    :param coefficients: (k, 6, 3n).
    :param start: (k, n) effort at the start of each segment [N*m or N].
    :param end: (k, n) effort at the end.
    :returns: (k, 6, 4n).
    """
    effort = np.zeros((*coefficients.shape[:2], start.shape[1]))
    effort[:, 0] = start
    effort[:, 1] = end - start
    return np.concatenate((coefficients, effort), axis=2)


def step_coefficients(end: Matrix) -> Matrix:
    """
    Return segments that stand at the values of their end, for the method ``none``.

    :param end: (k, w) all values of the waypoint at each segment's end.
    :returns: (k, 6, w).
    """
    c = np.zeros((end.shape[0], DEGREE + 1, end.shape[1]))
    c[:, 0] = end
    return c


def between(waypoints: Waypoints, *, splines: bool, effort: bool) -> Matrix:
    """
    Return the coefficients of the m - 1 segments between m waypoints.

    :param waypoints: with a position for every joint.
    :param splines: polynomials; else every segment stands at its end point's values.
    :param effort: whether effort is interpolated too.
    """
    if not splines:
        return step_coefficients(values(waypoints, effort=effort)[1:])
    states = np.stack((waypoints.positions, waypoints.velocities, waypoints.accelerations))
    levels = waypoints.levels
    c = spline_coefficients(
        np.diff(waypoints.times),
        np.minimum(levels[:-1], levels[1:]),
        states[:, :-1],
        states[:, 1:],
    )
    return with_effort(c, waypoints.effort[:-1], waypoints.effort[1:]) if effort else c


def values(waypoints: Waypoints, *, effort: bool) -> Matrix:
    """Return (m, 3n) or, with effort, (m, 4n) values of the points, 0 where not given."""
    blocks = [waypoints.positions, waypoints.velocities, waypoints.accelerations]
    if effort:
        blocks.append(waypoints.effort)
    return np.nan_to_num(np.concatenate(blocks, axis=1), nan=0.0)
