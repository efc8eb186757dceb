# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
TOPP-RA on a path of pieces.

Kept apart because importing toppra takes time: 0.9 s as it is, 0.1 s without plots, splines
through waypoints and other solvers' matrices, which are not needed here and are imported later.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
import math
import sys
from types import ModuleType
from typing import Any

import numpy as np

from armsim_ros.arrays import Vector


class _LaterName:
    """A name of a module that is imported when the name is called or something of it used."""

    def __init__(self, module: str, name: str) -> None:
        self._where = module, name

    def __getattr__(self, name: str) -> Any:
        if name.startswith('__'):
            raise AttributeError(name)
        return getattr(self._real(), name)

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        return self._real()(*args, **kwargs)

    def _real(self) -> Any:
        module, name = self._where
        return getattr(import_module(module), name)


class _LaterModule(ModuleType):
    """A module whose names are looked up when they are used."""

    #: Whether it represents the real module only, and no import reads its attributes.
    imported = False

    def __getattr__(self, name: str) -> Any:
        if name.startswith('__'):
            raise AttributeError(name)
        if self.imported:
            return getattr(import_module(self.__name__), name)
        return _LaterName(self.__name__, name)


@contextmanager
def imported_later(*modules: str) -> Iterator[None]:
    """
    Let what is imported meanwhile have names of modules without the time that they take.

    The modules' names are free again afterwards: later imports get the real ones, and
    holders of a name reach the real module through it. What is imported already stays.

    :param modules: full names, packages before what is in them.
    """
    later = {name: _LaterModule(name) for name in modules if name not in sys.modules}
    for name, module in later.items():
        package, _, child = name.rpartition('.')
        if package in later:
            setattr(later[package], child, module)
    sys.modules.update(later)
    try:
        yield
    finally:
        for name, module in later.items():
            module.imported = True
            if sys.modules.get(name) is module:
                del sys.modules[name]


with imported_later(
    'matplotlib', 'matplotlib.pyplot', 'scipy', 'scipy.interpolate', 'scipy.sparse'
):
    from toppra.constraint import DiscretizationType, LinearConstraint
    from toppra.solverwrapper.cy_seidel_solverwrapper import seidelWrapper

#: Squared speed is made so much lower, of it or of 1, that rounding leaves it allowed at the
#: next stage; and where a stage has no solution for it, to try again.
_RELATIVE_LOSS, _LOSS, _RETREAT = 1e-4, 1e-8, 1e-3
_TRIES = 11


class _PathView:
    """What toppra asks of a path before it asks the constraints."""

    def __init__(self, dof: int, end: float) -> None:
        self.dof = dof
        self.path_interval = np.array([0.0, end])


class _StageConstraint(LinearConstraint):  # type: ignore[misc] # toppra's, no types
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
    solver = seidelWrapper(
        [constraint], _PathView(first.shape[1], float(grid[-1])), grid, solve_lp1d=True)
    solver.setup_solver()
    squares = _forward(solver, np.diff(grid), _backward(solver, len(first)))
    solver.close_solver()
    return np.sqrt(squares) if bool(np.all(np.isfinite(squares))) else None


def _backward(solver: Any, stages: int) -> Vector:
    """Return the highest squared speed (stages + 1,) from which the end can be met at rest."""
    highest = np.zeros(stages + 1)
    objective = np.array([1e-9, -1.0])
    for stage in range(stages - 1, -1, -1):
        if math.isnan(highest[stage + 1]):
            highest[stage] = math.nan
            continue
        # Standing still is always allowed, so the lowest speeds are 0.
        highest[stage] = solver.solve_stagewise_optim(
            stage, None, objective, math.nan, math.nan, 0.0, highest[stage + 1])[1]
    return highest


def _forward(solver: Any, spans: Vector, highest: Vector) -> Vector:
    """Return the squared speeds (stages + 1,) of the quickest way below the highest ones."""
    squares = np.zeros(len(highest))
    for stage, span in enumerate(spans):
        objective = np.array([-2.0 * span, -1.0])
        for _ in range(_TRIES):
            here = squares[stage]
            rate = solver.solve_stagewise_optim(
                stage, None, objective, here, here, 0.0, highest[stage + 1])[0]
            if not math.isnan(rate):
                break
            squares[stage] = max(here - _LOSS, (1.0 - _RETREAT) * here)
        else:
            squares[stage + 1:] = math.nan
            break
        reached = here + 2.0 * span * rate
        reached = max(reached - _LOSS, (1.0 - _RELATIVE_LOSS) * reached)
        squares[stage + 1] = min(highest[stage + 1], max(0.0, reached))
    return squares
