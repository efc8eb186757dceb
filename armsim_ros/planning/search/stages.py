# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The stages of a search, the quickest first, and the motion that comes of it.

A stage looks for a path in its own way; the motion along that path is timed and proved to be
free. Where either fails, the next stage looks closer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from armsim_ros.arrays import Matrix
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.planning.collision.state_validity import CLEARANCE, HULL_CLEARANCE, SEARCH_STEP
from armsim_ros.planning.search.path_search import (
    no_path,
    repaired,
    search,
    SearchProblem,
    Stage,
)
from armsim_ros.planning.search.shortening import path_length
from armsim_ros.planning.timing.quintic import QuinticMotion

Motion = tuple[Matrix, QuinticMotion]
"""A path (k, m) and the motion along it."""

FINER = (1.0, 0.5, *(0.25 for _ in range(10)))
"""What the fine step is multiplied with, round by round."""

RESERVE = 2.0
"""No further search begins where less time is left than so many of the longest one so far."""

_FEW_MOTIONS, _MOTIONS = 3000, 8000


def stages(problem: SearchProblem) -> Iterator[Stage]:
    """
    Yield the ways to look for a path.

    The straight line; hulls with room to spare; hulls close by; the shapes themselves in fine
    steps; then the last two again, in finer steps. Hulls are left out where start or goals are
    not free on them or where pose constraints have to be kept.
    """
    near = problem.validity.clearance
    exact = [Stage(True, near, problem.fine_step * part, problem.fine_step * part)
             for part in FINER]
    if problem.constrained:
        yield replace(exact[0], straight=True)
        yield from exact
        return
    coarse = Stage(True, near, SEARCH_STEP, problem.fine_step, _MOTIONS)
    if problem.ends_free(exact=False):
        near = CLEARANCE if problem.ends_free(exact=False, clearance=CLEARANCE) else 0.0
        coarse = replace(coarse, exact=False, clearance=near)
    yield replace(coarse, straight=True)
    if near and problem.ends_free(exact=False, clearance=HULL_CLEARANCE):
        yield replace(coarse, clearance=HULL_CLEARANCE, most_motions=_FEW_MOTIONS)
    yield coarse
    yield exact[0]
    for stage in exact[1:]:
        yield replace(coarse, fine_step=stage.step)
        yield stage


def find_motion(
    problem: SearchProblem, timed: Callable[[Matrix, float, bool], QuinticMotion]
) -> Motion:
    """
    Return a path and the motion along it, from the first stage whose motion is free.

    :param timed: (path, step, rough) -> its motion, proved in steps [m]; raises PlanningError
        with INVALID_MOTION_PLAN where it is not free. A rough path was not checked in fine
        steps before, and is not changed so that its motion becomes free.
    :raises PlanningError: TIMED_OUT, PLANNING_FAILED or PREEMPTED where there is no path;
        INVALID_MOTION_PLAN where no motion along one is free.
    """
    problem.validity.keep_clear(problem.ends)
    failure: PlanningError | None = None
    for stage in stages(problem):
        path = search(problem, stage)
        if path is None:
            if stage.last:
                raise no_path(problem)
            continue
        try:
            motion = _proved(path, problem, stage, timed)
        except PlanningError as error:
            if error.code != MoveItErrorCode.INVALID_MOTION_PLAN or problem.budget.spent():
                raise
            failure = error
        else:
            problem.budget.check('ValidateSolution')
            return motion
    raise failure or no_path(problem)


def _proved(
    path: Matrix, problem: SearchProblem, stage: Stage,
    timed: Callable[[Matrix, float, bool], QuinticMotion],
) -> Motion:
    if stage.rough:
        # What proves the motion proves the path: most paths need no look of their own.
        try:
            return path, timed(path, stage.fine_step, True)
        except PlanningError as error:
            if error.code != MoveItErrorCode.INVALID_MOTION_PLAN:
                raise
        path = repaired(path, problem, stage)
    return path, timed(path, stage.fine_step, False)


def shortest_motion(problem: SearchProblem, find: Callable[[], Motion]) -> Motion:
    """
    Return the motion with the shortest path of all that are found while there is time.

    :raises PlanningError: as ``find`` does at first; later only where it is PREEMPTED.
    """
    best, longest, budget = find(), 0.0, problem.budget
    while len(best[0]) > 2 and not budget.spent() and (
        budget.clock() + RESERVE * longest < budget.deadline
    ):
        began = budget.clock()
        try:
            best = min(best, find(), key=lambda motion: path_length(motion[0]))
        except PlanningError as error:
            if error.code == MoveItErrorCode.PREEMPTED:
                raise
        longest = max(longest, budget.clock() - began)
    budget.check('anytime')
    return best
