# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
TOPP-RA on a path of pieces.

Kept apart because importing toppra takes time. Most of it would be that of plots and of splines
through waypoints, which nobody needs here.
"""

from __future__ import annotations

import logging

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.later_imports import imported_later

with imported_later('matplotlib', 'matplotlib.pyplot', 'scipy.interpolate'):
    from toppra.algorithm import ParameterizationReturnCode, TOPPRA
    from toppra.constraint import DiscretizationType, LinearConstraint

logging.getLogger('toppra').setLevel(logging.CRITICAL)


class _PathView:
    """What toppra asks of a path before it asks the constraints."""

    def __init__(self, dof: int, end: float) -> None:
        self.dof = dof
        self.path_interval = np.array([0.0, end])


class _StageConstraint(LinearConstraint):  # type: ignore[misc]
    """
    Joint accelerations at both ends of every stage, path speed at its borders.

    At a knot the second derivative jumps; each stage takes the values of its own side. On a
    stage the path acceleration u is constant and x = speed^2 is linear in path position, so
    q'(s) u + q'' x is linear as well and bounded in between.
    """

    def __init__(
        self, grid: Vector, first: Vector, last: Vector, curvature: Vector,
        fastest: Vector, acceleration: Vector,
    ) -> None:
        super().__init__()
        self.set_discretization_type(DiscretizationType.Collocation)
        self.identical = True
        self.dof = first.shape[1]
        span = np.diff(grid)[:, None]
        # x at the end of a stage is x + 2 u span.
        a = np.concatenate([first, last + 2.0 * span * curvature], axis=1)
        b = np.concatenate([curvature, curvature], axis=1)
        self._a = np.concatenate([a, a[-1:]])
        self._b = np.concatenate([b, np.zeros_like(b[-1:])])
        self._limit = np.concatenate([acceleration, acceleration])
        self._x = np.stack([np.zeros_like(fastest), np.minimum(fastest**2, 1e8)], axis=1)

    def compute_constraint_params(self, path: object, gridpoints: Vector) -> tuple[object, ...]:
        """Return a, b, c, F, h, bounds of u, bounds of x as toppra names them."""
        count = self._a.shape[1]
        F = np.concatenate([np.eye(count), -np.eye(count)])
        h = np.concatenate([self._limit, self._limit])
        return self._a, self._b, np.zeros_like(self._a), F, h, None, self._x


def fastest_path_speed(
    grid: Vector, first: Vector, last: Vector, curvature: Vector,
    fastest: Vector, acceleration: Vector,
) -> Vector | None:
    """
    Return the path speed at every border of the stages, from rest to rest.

    :param grid: (k + 1,) path positions.
    :param first: (k, n) slope where each stage begins.
    :param last: (k, n) slope where it ends.
    :param curvature: (k, n) second derivative on the stage.
    :param fastest: (k + 1,) largest path speed.
    :param acceleration: (n,) joint acceleration limits.
    :returns: (k + 1,), or None where nothing keeps the limits.
    """
    constraint = _StageConstraint(grid, first, last, curvature, fastest, acceleration)
    solver = TOPPRA(
        [constraint], _PathView(first.shape[1], float(grid[-1])), gridpoints=grid,
        solver_wrapper='seidel', parametrizer='ParametrizeConstAccel',
    )
    solver.compute_parameterization(0.0, 0.0)
    if solver.problem_data.return_code != ParameterizationReturnCode.Ok:
        return None
    speed: Vector = np.asarray(solver.problem_data.sd_vec, dtype=np.float64)
    return speed if bool(np.all(np.isfinite(speed))) else None
