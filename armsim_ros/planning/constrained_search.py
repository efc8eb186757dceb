# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Paths on which a link keeps a pose constraint, found by projection.

Two trees grow towards each other in small steps, each of which is projected onto the states
that keep the constraints (CBiRRT2, Berenson et al. 2011, DOI 10.1177/0278364910396389).
"""

from __future__ import annotations

from collections.abc import Callable
import math

import numpy as np
from numpy.typing import NDArray

from armsim_ros.planning.constraints import ConstraintSet
from armsim_ros.planning.search_tree import SearchTree
from armsim_ros.planning.state_validity import StateValidity

Vector = NDArray[np.float64]

STEP = 0.1
"""Length of a step before it is projected [rad or m]."""

_MARGIN = 0.1
_NEWTON_STEPS = 25
_RESIDUAL = 1e-7
_DIFFERENCE = 1e-6
_SHORTCUTS = 60


class ConstrainedSearch:
    """
    Searches for paths whose every state keeps path constraints.

    :param validity: with path constraints.
    :param step: largest motion [m] of any point between two checks.
    :param rng: source of chance.
    """

    def __init__(
        self, validity: StateValidity, step: float, rng: np.random.Generator
    ) -> None:
        """Take the constraints from the validity."""
        if validity.path_constraints is None:
            raise ValueError('there are no path constraints')
        self._validity = validity
        self._constraints: ConstraintSet = validity.path_constraints
        self._step = step
        self._rng = rng
        low, high = validity.search_lower, validity.search_upper
        self._low, self._high = low, high

    def find(
        self, start: Vector, goals: tuple[Vector, ...], stop: Callable[[], bool]
    ) -> Vector | None:
        """
        Return the waypoints (k, m) of a path, None where none was found in time.

        :param start: (m,) free, keeps the constraints.
        :param goals: (m,) likewise, the preferred one first.
        """
        for goal in goals:
            direct = self._follow(start, goal, stop)
            if len(direct) and np.array_equal(direct[-1], goal):
                return np.concatenate([start[None], direct])
        found = self._grow(start, goals, stop)
        return None if found is None else self._shortened(found, stop)

    def project(self, values: Vector) -> Vector | None:
        """
        Return the state (m,) that keeps the constraints near a given one, or None.

        Gauss-Newton steps of least length on what exceeds the tolerances.
        """
        x = np.clip(values, self._low, self._high)
        for _ in range(_NEWTON_STEPS):
            residual = self._residual(x)
            if float(np.max(np.abs(residual), initial=0.0)) < _RESIDUAL:
                return x
            jacobian = np.empty((len(residual), len(x)))
            for k in range(len(x)):
                moved = x.copy()
                moved[k] += _DIFFERENCE
                jacobian[:, k] = (self._residual(moved) - residual) / _DIFFERENCE
            correction = np.linalg.lstsq(jacobian, -residual, rcond=1e-4)[0]
            length = float(np.linalg.norm(correction))
            x = np.clip(x + correction * min(1.0, 0.5 / max(length, 1e-12)),
                        self._low, self._high)
        return None

    def _residual(self, values: Vector) -> Vector:
        return self._constraints.residual(self._validity.full(values), _MARGIN)

    def _follow(self, a: Vector, b: Vector, stop: Callable[[], bool]) -> Vector:
        """Return states (k, m) from a, which is left out, towards b, as far as they are free."""
        path: list[Vector] = []
        here = a
        while not stop():
            way = b - here
            distance = float(np.linalg.norm(way))
            if distance < 1e-9:
                break
            step = STEP
            following = None
            while following is None and step > STEP / 10.0:
                following = self._next(here, b, way, distance, step)
                step *= 0.4
            if following is None:
                break
            path.append(following)
            here = following
        return np.array(path).reshape(-1, len(a))

    def _next(
        self, here: Vector, target: Vector, way: Vector, distance: float, step: float
    ) -> Vector | None:
        if distance <= step:
            following: Vector | None = target
        else:
            following = self.project(here + way * (step / distance))
        if following is None:
            return None
        # Projection may push back or aside: only real progress counts.
        left = float(np.linalg.norm(target - following))
        moved = float(np.linalg.norm(following - here))
        if left > distance - 0.05 * step or moved > 3.0 * step:
            return None
        if not self._validity.motion_free(here, following, self._step):
            return None
        return following

    def _grow(
        self, start: Vector, goals: tuple[Vector, ...], stop: Callable[[], bool]
    ) -> Vector | None:
        trees = [SearchTree(start[None]), SearchTree(np.array(goals))]
        low = np.where(np.isfinite(self._low), self._low, start - math.pi)
        high = np.where(np.isfinite(self._high), self._high, start + math.pi)
        active = 0
        while not stop():
            one, other = trees[active], trees[1 - active]
            sample = self._rng.uniform(low, high)
            last, _ = one.nearest(sample)
            for values in self._follow(one[last].copy(), sample, stop):
                last = one.add(last, values)
            reached = one[last].copy()
            end, _ = other.nearest(reached)
            for values in self._follow(other[end].copy(), reached, stop):
                end = other.add(end, values)
            if float(np.linalg.norm(other[end] - reached)) < 1e-9:
                first, second = one.branch(last), other.branch(end)
                if active:
                    first, second = second, first
                return np.concatenate([first[::-1], second[1:]])
            active = 1 - active
        return None

    def _shortened(self, waypoints: Vector, stop: Callable[[], bool]) -> Vector:
        path = waypoints
        for _ in range(_SHORTCUTS):
            if len(path) < 3 or stop():
                break
            i, j = sorted(self._rng.choice(len(path), 2, replace=False))
            if j - i < 2:
                continue
            before = float(np.sum(np.linalg.norm(np.diff(path[i:j + 1], axis=0), axis=1)))
            shorter = self._follow(path[i], path[j], stop)
            if not len(shorter) or not np.array_equal(shorter[-1], path[j]):
                continue
            both = np.concatenate([path[i:i + 1], shorter])
            if float(np.sum(np.linalg.norm(np.diff(both, axis=0), axis=1))) < before - 1e-6:
                path = np.concatenate([path[:i], both, path[j + 1:]])
        return path
