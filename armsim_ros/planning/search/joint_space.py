# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The joint space of a planning group as a search moves in it: bounds, motions, steering."""

from __future__ import annotations

import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.planning.collision.state_validity import StateValidity

DEFAULT_RANGE = 0.75
"""Length of an extension of a search tree [rad or m]; OMPL's own is several times longer."""

PROJECTION_STEP = 0.1
"""Length of a step before it is projected [rad or m]."""

_CORNER_STEP = 0.25  # of the search's step
_MARGIN = 0.1
_NEWTON_STEPS = 25
_RESIDUAL = 1e-7
_DIFFERENCE = 1e-6
_SHORTENING = 0.4
_LEAST_STEP = 0.1
_SAME = 1e-9


class JointSpace:
    """
    Where a search moves: straight motions between states within bounds.

    A continuous joint is a real number within one turn and a half of the start, so that paths
    come out unwound.

    :param validity: checks states and motions.
    :param start: (m,) where the search begins [rad or m].
    :param step: largest motion of any point between two checks [m].
    :param exact: check on exact geometry, else on hulls.
    :param clearance: what motions keep from everything [m].
    """

    def __init__(
        self, validity: StateValidity, start: Vector, step: float, exact: bool,
        clearance: float = 0.0,
    ) -> None:
        self.validity, self.step, self.exact, self.clearance = validity, step, exact, clearance
        #: Motions that were asked for.
        self.motions = 0
        lower, upper = validity.search_lower, validity.search_upper
        lower = np.where(np.isfinite(lower), lower, start - 3.0 * math.pi)
        upper = np.where(np.isfinite(upper), upper, start + 3.0 * math.pi)
        # A start that is out of its limits by no more than rounding has to be in the space.
        lower, upper = np.minimum(lower, start), np.maximum(upper, start)
        #: Where states are sampled (m,).
        self.low, self.high = lower, np.maximum(upper, lower + 1e-9)
        self._nothing: Matrix = np.empty((0, len(start)))
        self._free = validity.motion_test(step, exact, clearance)

    @property
    def extension(self) -> float:
        """Length of an extension of a search tree [rad or m]."""
        return min(DEFAULT_RANGE, 0.2 * float(np.linalg.norm(self.high - self.low)))

    def free(self, values: Vector) -> bool:
        """Return whether a state (m,) is free."""
        return self.validity.free(values, self.exact)

    def motion_free(self, first: Vector, second: Vector) -> bool:
        """Return whether the straight motion from a free state (m,) to another is free."""
        self.motions += 1
        return self._free(first, second, False)

    def shortcut_free(self, first: Vector, second: Vector) -> bool:
        """Return whether the straight motion between two states of a free path is free."""
        self.motions += 1
        return self._free(first, second, True)

    def corner_free(self, first: Vector, second: Vector) -> bool:
        """Return whether a shortcut is free that cuts a corner: in smaller steps, it is close."""
        return self.validity.motion_free(
            first, second, _CORNER_STEP * self.step, self.exact, self.clearance, between=True)

    def join(self, first: Vector, second: Vector) -> Matrix | None:
        """Return nothing (0, m) between two states of a free path with a free motion, or None."""
        return self._nothing if self.shortcut_free(first, second) else None

    def steer(self, state: Vector, target: Vector, distance: float, longest: float) -> Matrix:
        """
        Return states (k, m) on the way from a state, which is left out, to a target.

        :param distance: between the two [rad or m].
        :param longest: way to go at most; the target itself is the last state where it is not
            farther. None are returned where the way is blocked.
        """
        following = target if distance <= longest else (
            state + (target - state) * (longest / distance))
        self.motions += 1
        return following[None] if self._free(state, following, False) else self._nothing


class ConstrainedSpace(JointSpace):
    """
    The states that keep the path constraints: every step is projected onto them.

    CBiRRT2 (Berenson et al. 2011, DOI 10.1177/0278364910396389) steers a search this way.
    Parameters are those of :class:`JointSpace`; the validity has path constraints.
    """

    def join(self, first: Vector, second: Vector) -> Matrix | None:
        """Return projected states (k, m) between two, None where they cannot be joined."""
        found = self.steer(first, second, float(np.linalg.norm(second - first)), math.inf)
        if not len(found) or not np.array_equal(found[-1], second):
            return None
        return found[:-1]

    def steer(self, state: Vector, target: Vector, distance: float, longest: float) -> Matrix:
        """Return projected states (k, m) towards a target, as far as they are free."""
        path: list[Vector] = []
        here, left = state, min(distance, longest)
        while distance > _SAME and left > _SAME:
            self.validity.poll()
            step = PROJECTION_STEP
            following = None
            while following is None and step > _LEAST_STEP * PROJECTION_STEP:
                following = self._next(here, target, distance, step)
                step *= _SHORTENING
            if following is None:
                break
            path.append(following)
            left -= float(np.linalg.norm(following - here))
            here = following
            distance = float(np.linalg.norm(target - here))
        return np.array(path).reshape(-1, len(state))

    def project(self, values: Vector) -> Vector | None:
        """
        Return the state (m,) that keeps the constraints near a given state, or None.

        Gauss-Newton steps of least length on what exceeds the tolerances.
        """
        x = np.clip(values, self.low, self.high)
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
            x = np.clip(
                x + correction * min(1.0, 0.5 / max(length, 1e-12)), self.low, self.high)
        return None

    def _residual(self, values: Vector) -> Vector:
        constraints = self.validity.path_constraints
        assert constraints is not None
        return constraints.residual(self.validity.full(values), _MARGIN)

    def _next(
        self, here: Vector, target: Vector, distance: float, step: float
    ) -> Vector | None:
        following: Vector | None = target
        if distance > step:
            following = self.project(here + (target - here) * (step / distance))
        if following is None:
            return None
        # Projection may push back or aside: only real progress counts.
        left = float(np.linalg.norm(target - following))
        moved = float(np.linalg.norm(following - here))
        if left > distance - 0.05 * step or moved > 3.0 * step:
            return None
        return following if self.motion_free(here, following) else None
