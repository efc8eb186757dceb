# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A free path from a start to one of several goals.

First the straight line; then RRT-Connect, or the OMPL planner that was asked for, in large
steps on hulls; the path found is shortened. Where the motion along it is not free, the path is
checked as a whole on exact geometry in small steps, and only the pieces that fail are searched
again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
import math

import numpy as np
from numpy.typing import NDArray

from armsim_ros.errors import PlanningError
from armsim_ros.planning.constrained_search import ConstrainedSearch
from armsim_ros.planning.error_codes import MoveItErrorCode
from armsim_ros.planning.log import Log
from armsim_ros.planning.ompl_space import JointSpace
from armsim_ros.planning.planners import make_planner, PlannerChoice, THREADED
from armsim_ros.planning.rrt_connect import RRTConnect
from armsim_ros.planning.smoothing import path_length, shortened, without_repeats
from armsim_ros.planning.state_validity import (
    CLEARANCE,
    FINE_STEP,
    SEARCH_STEP,
    StateValidity,
)

Vector = NDArray[np.float64]

_SOURCE = 'OMPL'
_STRAIGHT_GOALS = 4
_CLEAR_MOTIONS = 3000
_ROUGH_MOTIONS = 8000
_REPAIR_MOTIONS = 600
# A path that took few motions to find and is so much longer than the straight line is searched
# a second time: another one is often shorter, and costs less than it saves on the way.
_CHEAP_MOTIONS = 600
_DETOUR = 0.2
_LAST_FAILURES = 4


@dataclass(frozen=True, slots=True)
class Budget:
    """
    When a search has to end.

    :param clock: returns the time [s].
    :param deadline: in the clock's time [s].
    :param cancelled: returns whether the client has lost interest.
    """

    clock: Callable[[], float]
    deadline: float
    cancelled: Callable[[], bool]

    def spent(self) -> bool:
        """Return whether to stop."""
        return self.cancelled() or self.clock() >= self.deadline

    def now(self) -> float:
        """Return the clock's time [s], infinite where nobody waits any more."""
        return math.inf if self.cancelled() else self.clock()

    def check(self, stage: str) -> None:
        """Raise PREEMPTED where the request was cancelled."""
        if self.cancelled():
            raise PlanningError(
                MoveItErrorCode.PREEMPTED, 'the request was cancelled while planning', stage
            )


@dataclass(frozen=True, slots=True, eq=False)
class SearchProblem:
    """
    What to search.

    :param start: (m,) a free state [rad or m].
    :param goals: (m,) free states, the preferred one first.
    :param rng: source of chance beside OMPL's own.
    :param fine_step: largest motion of any point between two checks of the result [m].
    """

    validity: StateValidity
    start: Vector
    goals: tuple[Vector, ...]
    planner: PlannerChoice
    rng: np.random.Generator
    fine_step: float = FINE_STEP


def find_path(problem: SearchProblem, budget: Budget, attempts: int, log: Log) -> Vector:
    """
    Return the waypoints (k, m) of a path that is free on exact geometry.

    Parameters and errors are those of :func:`find_rough_path`.
    """
    waypoints, exact = find_rough_path(problem, budget, attempts, log)
    return waypoints if exact else mended(waypoints, problem, budget, log)


def find_rough_path(
    problem: SearchProblem, budget: Budget, attempts: int, log: Log
) -> tuple[Vector, bool]:
    """
    Return the waypoints (k, m) of a path, the shortest of several attempts.

    :param attempts: number of searches; fewer where the time is over and one succeeded.
    :returns: the path, and whether it was checked finely; else only in the search's steps.
    :raises PlanningError: TIMED_OUT, PLANNING_FAILED or PREEMPTED with what was tried.
    """
    validity = problem.validity
    ends = (problem.start, *problem.goals)
    validity.keep_clear(ends)
    straight = straight_path(problem)
    if straight is not None:
        return straight, True
    validity.keep_clear_of_hulls(ends)
    best: tuple[Vector, bool] | None = None
    failure: PlanningError | None = None
    for _ in range(max(1, attempts)):
        try:
            found = _attempt(problem, budget, log)
        except PlanningError as error:
            if error.code == MoveItErrorCode.PREEMPTED:
                raise
            failure = error
        else:
            if best is None or path_length(found[0]) < path_length(best[0]):
                best = found
        if budget.spent():
            break
    if best is not None:
        return best
    assert failure is not None
    raise failure


def mended(waypoints: Vector, problem: SearchProblem, budget: Budget, log: Log) -> Vector:
    """
    Return a path that is free on exact geometry; what is not free of one is searched again.

    :param waypoints: (k, m) from start to goal.
    :raises PlanningError: TIMED_OUT, PLANNING_FAILED or PREEMPTED where there is none.
    """
    whole = _repaired(waypoints, problem, budget, log)
    return _searched_finely(problem, budget, log) if whole is None else whole


def straight_path(problem: SearchProblem) -> Vector | None:
    """Return the straight line to the nearest goal that can be reached so, or None."""
    validity = problem.validity
    exact = not _on_hulls(problem)
    for goal in problem.goals[:_STRAIGHT_GOALS]:
        if validity.motion_free(
            problem.start, goal, SEARCH_STEP, exact
        ) and validity.motion_free(problem.start, goal, problem.fine_step):
            return np.array([problem.start, goal])
    return None


def _attempt(problem: SearchProblem, budget: Budget, log: Log) -> tuple[Vector, bool]:
    validity = problem.validity
    constraints = validity.path_constraints
    if constraints is not None and (constraints.positions or constraints.orientations):
        search = ConstrainedSearch(validity, problem.fine_step, problem.rng)
        kept = search.find(problem.start, problem.goals, budget.spent)
        budget.check(_SOURCE)
        if kept is None:
            raise _no_path(problem, budget)
        return without_repeats(kept), True
    found, motions = _rough(problem, budget, log)
    if found is None and validity.hull_clearance > CLEARANCE and not budget.spent():
        validity.hull_clearance = CLEARANCE
        found, motions = _rough(problem, budget, log)
    if found is None:
        return _searched_finely(problem, budget, log), True
    if motions < _CHEAP_MOTIONS and problem.planner.simplify and _is_detour(found):
        other, _ = _rough(problem, budget, log)
        if other is not None and path_length(other) < path_length(found):
            found = other
    return found, False


def _rough(
    problem: SearchProblem, budget: Budget, log: Log
) -> tuple[Vector | None, int]:
    """Return a path that was looked at in the search's steps, and the motions looked at."""
    exact = not _on_hulls(problem)
    space = JointSpace(problem.validity, problem.start, SEARCH_STEP, exact)
    clear = not exact and problem.validity.hull_clearance > CLEARANCE
    found = _solve(space, problem, budget, log, _CLEAR_MOTIONS if clear else _ROUGH_MOTIONS)
    return found, space.motions_checked


def _is_detour(waypoints: Vector) -> bool:
    straight = float(np.linalg.norm(waypoints[-1] - waypoints[0]))
    return path_length(waypoints) > (1.0 + _DETOUR) * straight


def _on_hulls(problem: SearchProblem) -> bool:
    """Return whether start and goals are free even where meshes count as their hulls."""
    return all(
        problem.validity.free(values, exact=False) for values in (problem.start, *problem.goals)
    )


def _searched_finely(problem: SearchProblem, budget: Budget, log: Log) -> Vector:
    space = JointSpace(problem.validity, problem.start, problem.fine_step, exact=True)
    found = _solve(space, problem, budget, log)
    if found is None:
        raise _no_path(problem, budget)
    return found


def _solve(
    space: JointSpace, problem: SearchProblem, budget: Budget, log: Log,
    most_motions: int | None = None,
) -> Vector | None:
    """Return a shortened path, None where none was found; PREEMPTED where cancelled."""
    planner = make_planner(problem.planner, space.information, space.extension, log)
    definition = None if problem.planner.own_search else space.problem(
        problem.start, problem.goals)

    def stop() -> bool:
        spent = most_motions is not None and space.motions_checked > most_motions
        # A planner that has a path and goes on makes it shorter: that takes what time there is.
        if spent and (definition is None or not definition.hasExactSolution()):
            return True
        return budget.spent()

    if definition is None:
        search = RRTConnect(
            space.low, space.high, space.motion_free, float(planner.getRange()), problem.rng)
        found = search.find(problem.start, problem.goals, stop)
        budget.check(_SOURCE)
        if found is None:
            return None
        waypoints = found
    else:
        planner.setProblemDefinition(definition)
        planner.setup()
        with problem.validity.unpolled():
            planner.solve(space.termination(stop, problem.planner.type in THREADED))
        space.ended()
        budget.check(_SOURCE)
        if not definition.hasExactSolution():
            return None
        states = definition.getSolutionPath().getStates()
        waypoints = np.array([space.values(state) for state in states])
    waypoints[0] = problem.start
    waypoints = without_repeats(waypoints)
    if not problem.planner.simplify:
        return waypoints
    return shortened(
        waypoints, space.motion_free, problem.rng, budget.spent,
        corner_free=space.corner_free)


def _repaired(
    waypoints: Vector, problem: SearchProblem, budget: Budget, log: Log
) -> Vector | None:
    """Return the path with every piece free on exact geometry; None where that failed."""
    validity = problem.validity
    pieces: list[Vector] = [waypoints[:1]]
    repaired = False
    for a, b in pairwise(waypoints):
        if validity.motion_free(a, b, problem.fine_step):
            pieces.append(b[None])
            continue
        if not validity.free(b, clearance=validity.clearance) or budget.spent():
            return None
        space = JointSpace(validity, a, problem.fine_step, exact=True)
        part = replace(problem, start=a, goals=(b,), planner=problem.planner.for_repairs())
        detour = _solve(space, part, budget, log, most_motions=_REPAIR_MOTIONS)
        if detour is None:
            return None
        pieces.append(detour[1:])
        repaired = True
    result = np.concatenate(pieces)
    if repaired and problem.planner.simplify:
        space = JointSpace(validity, result[0], problem.fine_step, exact=True)
        result = shortened(
            without_repeats(result), space.motion_free, problem.rng, budget.spent, _LAST_FAILURES)
    return without_repeats(result)


def _no_path(problem: SearchProblem, budget: Budget) -> PlanningError:
    count = len(problem.goals)
    goals = 'one goal configuration' if count == 1 else f'{count} goal configurations'
    where = np.round(problem.goals[0], 3).tolist()
    if budget.spent():
        return PlanningError(
            MoveItErrorCode.TIMED_OUT,
            f'{problem.planner.name} found no path to {goals} (nearest {where}) within the '
            'allowed time; raise allowed_planning_time, or check that no object blocks the way',
            _SOURCE,
        )
    return PlanningError(
        MoveItErrorCode.PLANNING_FAILED,
        f'{problem.planner.name} gave up before the allowed time was over; no path to {goals} '
        f'(nearest {where}); try the planner RRTConnect',
        _SOURCE,
    )
