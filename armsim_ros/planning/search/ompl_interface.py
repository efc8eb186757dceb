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
from armsim_ros.planning.search.joint_space import JointSpace
from armsim_ros.planning.search.planners import make_planner, PlannerChoice, THREADED

_LARGE_SEED = 2**31 - 1

ou.setLogLevel(ou.LOG_NONE)


def seed_search(seed: int) -> None:
    """Make the searches that begin after this call repeatable."""
    ou.RNG.setSeed(1 + seed % (_LARGE_SEED - 1))


def solve_with_ompl(
    space: JointSpace, choice: PlannerChoice, start: Vector, goals: Sequence[Vector],
    given_up: Callable[[], bool], over: Callable[[], bool], log: Log,
) -> Matrix | None:
    """
    Return the states (k, m) of a path to any of the goals; None where there is none in time.

    :param given_up: whether to stop without a path; a planner that has one and goes on makes
        it shorter, and that takes what time there is.
    :param over: whether to stop in any case.
    """
    view = OmplSpace(space)
    planner = make_planner(choice, view.information, space.extension, log)
    definition = view.problem(start, goals)

    def stop() -> bool:
        return over() or (given_up() and not definition.hasExactSolution())

    planner.setProblemDefinition(definition)
    planner.setup()
    with space.validity.unpolled():
        planner.solve(view.termination(stop, choice.type in THREADED))
    view.asked.ask = None
    if not definition.hasExactSolution():
        return None
    return np.array([view.values(state) for state in definition.getSolutionPath().getStates()])


class _Asked:
    """
    What checks call first, where the planner does not ask itself whether to end.

    It knows nothing of OMPL's objects: these hold it, and a circle through them is never freed.
    """

    __slots__ = ('ask',)

    def __init__(self) -> None:
        self.ask: Callable[[], object] | None = None


class _StateValidity(ob.StateValidityChecker):  # type: ignore[misc]
    """States by :class:`JointSpace`."""

    def __init__(self, information: Any, space: JointSpace, asked: _Asked) -> None:
        super().__init__(information)
        self._space, self._asked = space, asked
        self._places = range(len(space.low))

    def isValid(self, state: Any) -> bool:
        """Return whether a state is free."""
        if self._asked.ask is not None:
            self._asked.ask()
        return self._space.free(np.array([state[k] for k in self._places]))


class _MotionValidity(ob.MotionValidator):  # type: ignore[misc]
    """Motions by :class:`JointSpace`, in steps of bounded displacement."""

    def __init__(self, information: Any, space: JointSpace, asked: _Asked) -> None:
        super().__init__(information)
        self._space, self._asked = space, asked
        self._places = range(len(space.low))

    def checkMotion(self, first: Any, second: Any) -> bool:
        """Return whether the straight motion is free."""
        if self._asked.ask is not None:
            self._asked.ask()
        return self._space.motion_free(
            np.array([first[k] for k in self._places]),
            np.array([second[k] for k in self._places]))


class OmplSpace:
    """
    OMPL's state space, validity checker and motion validator for one search.

    :param space: judges states and motions.
    """

    def __init__(self, space: JointSpace) -> None:
        self._places = range(len(space.low))
        self.asked = _Asked()
        bounds = ob.RealVectorBounds(len(space.low))
        for k in self._places:
            bounds.setLow(k, float(space.low[k]))
            bounds.setHigh(k, float(space.high[k]))
        self.space = ob.RealVectorStateSpace(len(space.low))
        self.space.setBounds(bounds)
        self.information = ob.SpaceInformation(self.space)
        self.information.setStateValidityChecker(
            _StateValidity(self.information, space, self.asked))
        self.information.setMotionValidator(
            _MotionValidity(self.information, space, self.asked))
        self.information.setup()

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

        self.asked.ask = ask
        return condition

    def values(self, state: Any) -> Vector:
        """Return an OMPL state's values (m,)."""
        return np.array([state[k] for k in self._places])

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
