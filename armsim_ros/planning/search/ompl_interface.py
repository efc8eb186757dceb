# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Searches by OMPL's planners: a planning group's joint space as OMPL sees it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from ompl import base as ob
from ompl import util as ou

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.log import Log
from armsim_ros.planning.budget import nothing
from armsim_ros.planning.search.joint_space import JointSpace
from armsim_ros.planning.search.planners import make_planner, PlannerChoice, THREADED

_LARGE_SEED = 2**31 - 1

ou.setLogLevel(ou.LOG_NONE)


def seed_search(seed: int) -> None:
    """Make the searches that begin after this call repeatable."""
    ou.RNG.setSeed(1 + seed % (_LARGE_SEED - 1))


def solve_with_ompl(
    space: JointSpace, choice: PlannerChoice, start: Vector, goals: Sequence[Vector],
    stop: Callable[[], bool], log: Log,
) -> Matrix | None:
    """
    Return the states (k, m) of a path to any of the goals; None where there is none in time.

    A planner that shortens paths, such as RRTstar, goes on until it is stopped.

    :param stop: whether the search is to end, with a path or without.
    """
    checks = _Checks(space)
    information = _information(space, checks)
    planner = make_planner(choice, information, space.extension, log)
    definition = _problem(information, start, goals)

    if choice.type in THREADED:
        # A thread of its own asks the condition as well, and would wait for Python's lock, which
        # the search holds to its end.
        condition = ob.plannerNonTerminatingCondition()
        checks.ask = lambda: stop() and condition.terminate()
    else:
        condition = ob.PlannerTerminationCondition(stop)
    planner.setProblemDefinition(definition)
    planner.setup()
    with space.validity.unpolled():
        planner.solve(condition)
    checks.ask = nothing
    if not definition.hasExactSolution():
        return None
    return np.array([checks.values(state) for state in definition.getSolutionPath().getStates()])


class _Checks:
    """
    What OMPL's checkers ask, and what they call before where the planner itself does not.

    It knows nothing of OMPL's objects: these hold it, and a circle through them is never freed.
    """

    def __init__(self, space: JointSpace) -> None:
        self.space = space
        self.ask: Callable[[], object] = nothing
        self._places = range(len(space.low))

    def values(self, state: Any) -> Vector:
        """Return an OMPL state's values (m,)."""
        return np.array([state[k] for k in self._places])


class _StateValidity(ob.StateValidityChecker):  # type: ignore[misc] # compiled, no types
    """States by :class:`JointSpace`."""

    def __init__(self, information: Any, checks: _Checks) -> None:
        super().__init__(information)
        self._checks = checks

    def isValid(self, state: Any) -> bool:
        """Return whether a state is free."""
        self._checks.ask()
        return self._checks.space.free(self._checks.values(state))


class _MotionValidity(ob.MotionValidator):  # type: ignore[misc] # compiled, no types
    """Motions by :class:`JointSpace`, in steps of bounded displacement."""

    def __init__(self, information: Any, checks: _Checks) -> None:
        super().__init__(information)
        self._checks = checks

    def checkMotion(self, first: Any, second: Any) -> bool:
        """Return whether the straight motion is free."""
        self._checks.ask()
        values = self._checks.values
        return self._checks.space.motion_free(values(first), values(second))


def _information(space: JointSpace, checks: _Checks) -> Any:
    """Return OMPL's view of the space: bounds, validity checker, motion validator."""
    bounds = ob.RealVectorBounds(len(space.low))
    for k, (low, high) in enumerate(zip(space.low.tolist(), space.high.tolist(), strict=True)):
        bounds.setLow(k, low)
        bounds.setHigh(k, high)
    states = ob.RealVectorStateSpace(len(space.low))
    states.setBounds(bounds)
    information = ob.SpaceInformation(states)
    information.setStateValidityChecker(_StateValidity(information, checks))
    information.setMotionValidator(_MotionValidity(information, checks))
    information.setup()
    return information


def _problem(information: Any, start: Vector, goals: Sequence[Vector]) -> Any:
    """Return an OMPL problem from a start to any of several goals."""
    def state(values: Vector) -> Any:
        # The space's own allocState gives states that are never freed.
        made = information.allocState()
        for k, value in enumerate(values.tolist()):
            made[k] = value
        return made

    problem = ob.ProblemDefinition(information)
    problem.addStartState(state(start))
    region = ob.GoalStates(information)
    for goal in goals:
        region.addState(state(goal))
    problem.setGoal(region)
    problem.setOptimizationObjective(ob.PathLengthOptimizationObjective(information))
    return problem
