# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Polynomials between waypoints.

The coefficients of a segment (:mod:`armsim_ros.polynomials`) and those of its first two
derivatives by time are side by side in a single (6, 3n) or, with effort, (6, 4n) matrix, so that
a product with (1, u, .., u^5) gives the whole state.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Matrix
from armsim_ros.control.trajectory.waypoints import Waypoints
from armsim_ros.polynomials import DEGREE, hermite_coefficients, with_derivatives


def spline_coefficients(
    durations: Matrix, levels: NDArray[np.int64], start: Matrix, end: Matrix
) -> Matrix:
    """
    Return the coefficients (k, 6, 3n) of k segments of n joints and of their derivatives.

    Parameters are those of :func:`armsim_ros.polynomials.hermite_coefficients`.
    """
    return with_derivatives(hermite_coefficients(durations, levels, start, end), durations)


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
    Return segments that rest at the values of their end, for the method ``none``.

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
    :param splines: polynomials; else every segment rests at its end point's values.
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
