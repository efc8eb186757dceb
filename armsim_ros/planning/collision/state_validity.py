# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which states and motions of a group are free: collision, limits, path constraints."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property, lru_cache
import math

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.planning.budget import nothing, Poll, POLLED_STATES
from armsim_ros.planning.collision.broad_phase import CollisionTest
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.collision.contacts import Contact
from armsim_ros.planning.collision.near_pairs import Exactly, NearPairs
from armsim_ros.planning.constraints import ConstraintSet

SEARCH_STEP = 0.15
"""Largest motion [m] of any point of the robot between two checks of the search."""

FINE_STEP = 0.01
"""Largest motion [m] of any point of the robot between two checks of a found path."""

CLEARANCE = 0.001
"""What a path keeps from everything [m] where start and goals do, so that nothing is grazed."""

HULL_CLEARANCE = 0.005
"""What the search keeps from hulls [m] where start and goals do: paths are quicker to prove."""

_BOUND_TOLERANCE = 1e-6

MotionTest = Callable[[Vector, Vector, bool], bool]
"""Tests whether the motion between two states (m,) is free, see ``StateValidity.motion_test``."""


class StateValidity:
    """
    The free states of a group while all other joints rest.

    :param checker: follows the scene that is planned in.
    :param model: the robot's kinematics.
    :param group: a planning group.
    :param q: (n,) full robot state that gives the joints outside the group.
    :param path_constraints: to be kept at every state, or None.
    :param avoid_collisions: False ignores collisions.
    :param poll: called now and then within long checks; raises what ends the request.
    """

    def __init__(
        self, checker: CollisionChecker, model: KinematicModel, group: str, q: Vector,
        path_constraints: ConstraintSet | None = None, avoid_collisions: bool = True,
        poll: Poll = nothing,
    ) -> None:
        self._checker, self._model = checker, model
        self._base = model.apply_mimic(q)
        #: Where the group's variables are in a state; None where others follow them.
        self._places = model.places(group)
        #: Whether they are all there are.
        self._whole = isinstance(self._places, slice) and (
            len(self._base[self._places]) == len(self._base))
        self._avoid_collisions, self.poll, self.group = avoid_collisions, poll, group
        self.path_constraints = (
            None if path_constraints is None or path_constraints.empty else path_constraints
        )
        #: What motions shall keep from everything [m]; single states may be nearer.
        self.clearance = 0.0
        indices = model.group_indices(group)
        self.joint_names = tuple(model.names[index] for index in indices)
        self.lower: Vector = model.lower[indices]
        self.upper: Vector = model.upper[indices]
        self.search_lower, self.search_upper = self._tightened(indices)

    def _tightened(self, indices: NDArray[np.int64]) -> tuple[Vector, Vector]:
        """Return the bounds that joint path constraints leave of the limits."""
        lower, upper = self.lower.copy(), self.upper.copy()
        for term in self.path_constraints.joints if self.path_constraints else ():
            for place in np.flatnonzero(indices == term.index):
                if not term.continuous:
                    lower[place] = max(lower[place], term.lower)
                    upper[place] = min(upper[place], term.upper)
        return lower, upper

    @contextmanager
    def unpolled(self) -> Iterator[None]:
        """Leave out the poll: what it raises must not pass through threads of a library."""
        poll, self.poll = self.poll, nothing
        try:
            yield
        finally:
            self.poll = poll

    def full(self, values: Vector) -> Vector:
        """Return the full robot state (n,) for the group's values (m,)."""
        if self._places is None:
            return self._model.insert(self._base, self.group, values)
        q = self._base.copy()
        q[self._places] = values
        return q

    def collides(self, values: Vector) -> bool:
        """Return whether a state (m,) collides on exact geometry."""
        return self._avoid_collisions and bool(
            self._checker.in_collision(self.full(values), self.group)
        )

    def within_limits(self, values: Vector) -> bool:
        """Return whether a state (m,) lies within the joint limits."""
        return bool(
            np.all(values >= self.lower - _BOUND_TOLERANCE)
            and np.all(values <= self.upper + _BOUND_TOLERANCE)
        )

    def constrained(self, values: Vector) -> bool:
        """Return whether a state (m,) keeps the path constraints."""
        return self.path_constraints is None or self.path_constraints.satisfied(self.full(values))

    def free(self, values: Vector, exact: bool = True, clearance: float = 0.0) -> bool:
        """
        Return whether the robot may be in a state.

        :param values: (m,) [rad or m].
        :param exact: check collisions on exact geometry; else on the hulls, which may call a
            free state blocked but never the other way round.
        :param clearance: [m] nearer than this counts as touching.
        """
        return self._free(self.full(values), exact, clearance)

    def _free(self, q: Vector, exact: bool, clearance: float) -> bool:
        if self._avoid_collisions and self._checker.in_collision(
            q, self.group, clearance, exact
        ):
            return False
        return self.path_constraints is None or self.path_constraints.satisfied(q)

    def full_states(self, values: Matrix) -> Matrix:
        """Return the full robot states (k, n) for values (k, m) of the group."""
        if self._places is None:
            first = self.full(values[0])
            states: Matrix = first + (values - values[0]) @ self._model.gradient(self.group).T
        else:
            states = np.empty((len(values), len(self._base)))
            states[:] = self._base
            states[:, self._places] = values
        return states

    def blocked(
        self, values: Matrix, clearance: float = 0.0, pairs: NearPairs | None = None
    ) -> Mask:
        """
        Return which states (k, m) are not free, on exact geometry; for many states at once.

        :param clearance: [m] nearer than this counts as touching.
        :param pairs: of motions that hold the states.
        """
        found = self.near_pairs(values, None, clearance=clearance, before=pairs).motions
        if self.path_constraints is not None:
            for k in np.flatnonzero(~found):
                found[k] = not self.constrained(values[k])
        return found

    def near_pairs(
        self, values: Matrix, reach: Matrix | None, exact: Exactly = Exactly.ALWAYS,
        clearance: float = 0.0, before: NearPairs | None = None,
    ) -> NearPairs:
        """
        Return what may touch in motions by ``reach`` to either side of states (k, m).

        :param reach: (k, m) of every variable [rad or m]; None for the states alone.
        :param exact: when to check the shapes themselves where their hulls are near.
        :param clearance: [m] that shall be left.
        :param before: what this method has returned for wider motions that hold these.
        """
        if not self._avoid_collisions or not len(values):
            return NearPairs(np.zeros((len(values), 0, 0)), ())
        if reach is not None:
            reach = reach @ np.abs(self._model.gradient(self.group)).T
        return self._checker.near_pairs(
            self.full_states(values), reach, self.group, exact, clearance, self.poll, before)

    @cached_property
    def displacement_weights(self) -> Vector:
        """How far [m] any point moves at most per unit of each variable (m,)."""
        count = len(self.joint_names)
        zero = self.full(np.zeros(count))
        return np.array([
            self._checker.displacement_bound(zero, self.full(unit), self.group)
            for unit in np.eye(count)
        ])

    def motion_free(
        self, a: Vector, b: Vector, step: float = FINE_STEP, exact: bool = True,
        clearance: float | None = None, *, between: bool = False,
    ) -> bool:
        """
        Return whether the straight motion between two states is free.

        :param a: (m,) a state known to be free.
        :param b: (m,) a state, which is checked as well.
        :param between: check only states on the way: ``b`` is known to be free, too.
        :param step: see :data:`SEARCH_STEP` and :data:`FINE_STEP` [m].
        :param exact: see :meth:`free`.
        :param clearance: [m] that shall be left; None for :attr:`clearance`.
        """
        free = self.motion_test(step, exact, self.clearance if clearance is None else clearance)
        return free(a, b, between)

    def motion_test(self, step: float, exact: bool, clearance: float) -> MotionTest:
        """
        Return :meth:`motion_free` as a function of the states, for many motions.

        Parameters are those of :meth:`motion_free`; the function takes the states and ``between``.
        """
        weights, few = self.displacement_weights, POLLED_STATES[exact]
        test, full, full_states = self._test, self.full, self.full_states
        if self._whole:
            full = full_states = _same

        def free(a: Vector, b: Vector, between: bool = False) -> bool:
            blocked = test(exact, clearance)
            if not between and blocked(full(b)):
                return False
            way = b - a
            length = float(weights.dot(abs(way)))
            if length <= step:
                return True
            states = full_states(a + _halving_order(math.ceil(length / step)) * way)
            for begin in range(0, len(states), few):
                self.poll()
                for q in states[begin:begin + few]:
                    if blocked(q):
                        return False
            return True

        return free

    def _test(self, exact: bool, clearance: float) -> CollisionTest:
        """Return the fastest collision test of full states."""
        if not self._avoid_collisions or self.path_constraints is not None:
            return lambda q: not self._free(q, exact, clearance)
        return self._checker.test(self.group, clearance, exact)

    def keep_clear(self, ends: Sequence[Vector]) -> None:
        """Let motions keep clear of everything, as far as the states (m,) that they join do."""
        kept = all(self.free(values, clearance=CLEARANCE) for values in ends)
        self.clearance = CLEARANCE if kept else 0.0

    def why_not(self, values: Vector) -> str:
        """Return what is wrong with a state (m,), as a phrase, or ''."""
        for name, value, low, high in zip(
            self.joint_names, values, self.lower, self.upper, strict=True
        ):
            if not low - _BOUND_TOLERANCE <= value <= high + _BOUND_TOLERANCE:
                return (f"joint '{name}' at {value:.4f} is outside its limits "
                        f'{low:.4f} .. {high:.4f}')
        touching = self.touching(values)
        if touching:
            return touching
        if self.path_constraints is not None:
            return self.path_constraints.violation(self.full(values))
        return ''

    def contacts(self, values: Vector) -> tuple[Contact, ...]:
        """Return what touches what where the group's joints have values (m,)."""
        return tuple(self._checker.contacts(self.full(values), self.group))

    def touching(self, values: Vector) -> str:
        """Return the pairs that collide in a state (m,), as a phrase, or ''."""
        contacts = self.contacts(values)
        text = ', '.join(
            f"'{each.body1}' with '{each.body2}' ({each.depth * 1000.0:.1f} mm deep)"
            for each in contacts[:4]
        )
        more = f' and {len(contacts) - 4} more pairs' if len(contacts) > 4 else ''
        return f'{text}{more}'


def _same(values: Vector) -> Vector:
    """Return what is given."""
    return values


@lru_cache(maxsize=512)
def _halving_order(count: int) -> Vector:
    """Return 1/count .. (count - 1)/count (count - 1, 1) so that far apart ones come first."""
    parts: list[int] = []
    spans = [(0, count)]
    while spans:
        following = []
        for low, high in spans:
            middle = (low + high) // 2
            if middle > low:
                parts.append(middle)
                following += [(low, middle), (middle, high)]
        spans = following
    return np.array(parts, dtype=np.float64)[:, None] / count
