# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A planning group's joint space as OMPL sees it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from ompl import base as ob
from ompl import util as ou

from armsim_ros.planning.state_validity import StateValidity

Vector = NDArray[np.float64]

DEFAULT_RANGE = 0.5
"""Length of one extension of a search tree [rad or m]; OMPL's own is several times longer."""

_CORNER_STEP = 0.25  # of the search's step

_LARGE_SEED = 2**31 - 1

ou.setLogLevel(ou.LOG_NONE)


def seed_search(seed: int) -> None:
    """Make the searches that begin after this call repeatable."""
    ou.RNG.setSeed(1 + seed % (_LARGE_SEED - 1))


class _Probe:
    """
    Judges states and motions of one search, and counts the motions.

    It knows nothing of OMPL's objects: these hold it, and a circle through them is never freed.
    """

    __slots__ = ('ask', 'exact', 'motions', 'places', 'step', 'validity')

    def __init__(self, validity: StateValidity, step: float, exact: bool) -> None:
        self.validity = validity
        self.step = step
        self.exact = exact
        self.motions = 0
        self.ask: Callable[[], object] | None = None
        self.places = range(len(validity.joint_names))

    def values(self, state: Any) -> Vector:
        return np.array([state[k] for k in self.places])

    def motion_free(self, first: Vector, second: Vector) -> bool:
        self.motions += 1
        return self.validity.motion_free(first, second, self.step, self.exact)


class _Validity(ob.StateValidityChecker):  # type: ignore[misc]
    """States by :class:`StateValidity`."""

    def __init__(self, space_information: Any, probe: _Probe) -> None:
        super().__init__(space_information)
        self._probe = probe

    def isValid(self, state: Any) -> bool:
        """Return whether a state is free."""
        probe = self._probe
        if probe.ask is not None:
            probe.ask()
        return probe.validity.free(probe.values(state), probe.exact)


class _Motions(ob.MotionValidator):  # type: ignore[misc]
    """Motions by :class:`StateValidity`, in steps of bounded displacement."""

    def __init__(self, space_information: Any, probe: _Probe) -> None:
        super().__init__(space_information)
        self._probe = probe

    def checkMotion(self, first: Any, second: Any) -> bool:
        """Return whether the straight motion is free."""
        probe = self._probe
        if probe.ask is not None:
            probe.ask()
        return probe.motion_free(probe.values(first), probe.values(second))


class JointSpace:
    """
    OMPL's state space, validity checker and motion validator for one search.

    A continuous joint is a real number within one turn and a half of the start, so that paths
    come out unwound.

    :param validity: judges states and motions.
    :param start: (m,) where the search begins [rad or m].
    :param step: largest motion of any point between two checks [m].
    :param exact: judge on exact geometry, else on hulls.
    """

    def __init__(self, validity: StateValidity, start: Vector, step: float, exact: bool) -> None:
        """Build the space."""
        self._probe = _Probe(validity, step, exact)
        self._places = range(len(start))
        lower, upper = validity.search_lower, validity.search_upper
        lower = np.where(np.isfinite(lower), lower, start - 3.0 * math.pi)
        upper = np.where(np.isfinite(upper), upper, start + 3.0 * math.pi)
        # A start that is out of its limits by no more than rounding has to be in the space.
        lower, upper = np.minimum(lower, start), np.maximum(upper, start)
        #: Where states are sampled (m,).
        self.low, self.high = lower, np.maximum(upper, lower + 1e-9)
        bounds = ob.RealVectorBounds(len(start))
        for k in self._places:
            bounds.setLow(k, float(lower[k]))
            bounds.setHigh(k, float(self.high[k]))
        self.space = ob.RealVectorStateSpace(len(start))
        self.space.setBounds(bounds)
        self.information = ob.SpaceInformation(self.space)
        self.information.setStateValidityChecker(_Validity(self.information, self._probe))
        self.information.setMotionValidator(_Motions(self.information, self._probe))
        self.information.setup()

    @property
    def motions_checked(self) -> int:
        """Number of motions that the search has asked for."""
        return self._probe.motions

    @property
    def extension(self) -> float:
        """Length of one extension of a search tree [rad or m]."""
        return min(DEFAULT_RANGE, 0.2 * float(self.information.getMaximumExtent()))

    def termination(self, stop: Callable[[], bool], threaded: bool) -> Any:
        """
        Return OMPL's condition for the end of a search.

        :param stop: whether to end.
        :param threaded: for a planner that asks the condition from a thread of its own as well:
            that one would wait for Python's lock, which the search holds to its end.
        """
        if not threaded:
            return ob.PlannerTerminationCondition(stop)
        condition = ob.plannerNonTerminatingCondition()

        def ask() -> None:
            if stop():
                condition.terminate()

        self._probe.ask = ask
        return condition

    def motion_free(self, first: Vector, second: Vector) -> bool:
        """Return whether the straight motion from a free state (m,) to another is free."""
        return self._probe.motion_free(first, second)

    def corner_free(self, first: Vector, second: Vector) -> bool:
        """Return whether a motion is free that cuts a corner: in smaller steps, it is close."""
        probe = self._probe
        return probe.validity.motion_free(first, second, _CORNER_STEP * probe.step, probe.exact)

    def ended(self) -> None:
        """Let go of the condition for the end: the search is over."""
        self._probe.ask = None

    def values(self, state: Any) -> Vector:
        """Return an OMPL state's values (m,)."""
        return self._probe.values(state)

    def state(self, values: Vector) -> Any:
        """Return a new OMPL state with these values (m,)."""
        # The space's own allocState gives states that nobody frees.
        state = self.information.allocState()
        for k in self._places:
            state[k] = float(values[k])
        return state

    def problem(self, start: Vector, goals: Sequence[Vector]) -> Any:
        """Return an OMPL problem from a start to any of several goals."""
        problem = ob.ProblemDefinition(self.information)
        problem.addStartState(self.state(start))
        region = ob.GoalStates(self.information)
        for goal in goals:
            region.addState(self.state(goal))
        problem.setGoal(region)
        problem.setOptimizationObjective(ob.PathLengthOptimizationObjective(self.information))
        return problem
