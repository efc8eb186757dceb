# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The search for a path and the motion along it, in stages of which the quickest comes first.

A stage searches for a path in its own way; the motion along that path is timed and proved to be
free. Where either fails, the next stage looks closer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.log import Log
from armsim_ros.planning.budget import Budget
from armsim_ros.planning.collision.motion_proof import first_blocked
from armsim_ros.planning.collision.state_validity import (
    CLEARANCE,
    FINE_STEP,
    HULL_CLEARANCE,
    SEARCH_STEP,
    StateValidity,
)
from armsim_ros.planning.search.joint_space import ConstrainedSpace, JointSpace
from armsim_ros.planning.search.ompl_interface import solve_with_ompl
from armsim_ros.planning.search.planners import PlannerChoice, settings_of
from armsim_ros.planning.search.rrt_connect import RRTConnect
from armsim_ros.planning.search.shortening import (
    path_length,
    with_corners_cut,
    with_shortcuts,
    without_repeats,
)
from armsim_ros.planning.timing.limits import MotionLimits, SpeedLimit
from armsim_ros.planning.timing.path_timing import MAX_DEVIATION, time_waypoints
from armsim_ros.quintic_motion import QuinticMotion

_SOURCE = 'OMPL'
_STRAIGHT_GOALS = 4
_REPAIR_MOTIONS = 600
# A path that took few motions to find and is so much longer than the straight line is searched
# a second time, with as many motions at most: another path is often shorter.
_CHEAP_MOTIONS = 600
_DETOUR = 0.2
_LAST_FAILURES = 4


@dataclass(frozen=True, slots=True)
class Stage:
    """
    How closely a search looks.

    :param exact: at the shapes themselves, else at hulls of meshes, which is quicker.
    :param clearance: what motions keep from everything [m].
    :param step: largest motion of any point between two checks [m].
    :param fine_step: the same where the path that was found is checked [m].
    :param most_motions: checked before it gives up; None for no end but the budget's.
    :param straight: try the straight line only.
    :param further_goals: (m,) beside those of the problem.
    """

    exact: bool
    clearance: float
    step: float
    fine_step: float
    most_motions: int | None = None
    straight: bool = False
    further_goals: tuple[Vector, ...] = ()

    @property
    def rough(self) -> bool:
        """Whether a path that it finds has to be checked in finer steps."""
        return self.step > self.fine_step and not self.straight

    @property
    def last(self) -> bool:
        """Whether there is no path where it finds none."""
        return self.most_motions is None and not self.straight


@dataclass(frozen=True, slots=True, eq=False)
class SearchProblem:
    """
    What to search.

    :param start: (m,) a free state [rad or m].
    :param goals: (m,) free states, the preferred goal first.
    :param rng: source of chance beside OMPL's own.
    :param fine_step: largest motion of any point between two checks of the result [m].
    :param attempts: searches at a stage, of which the shortest path counts.
    :param path_tolerance: largest deviation of the motion from the path's corners [rad or m].
    :param turned_goals: returns goals (m,) a turn away, for where the others are out of reach.
    """

    validity: StateValidity
    start: Vector
    goals: tuple[Vector, ...]
    planner: PlannerChoice
    rng: np.random.Generator
    budget: Budget
    log: Log
    fine_step: float = FINE_STEP
    attempts: int = 1
    path_tolerance: float = MAX_DEVIATION
    turned_goals: Callable[[], tuple[Vector, ...]] = tuple

    @property
    def ends(self) -> tuple[Vector, ...]:
        """Start and goals."""
        return self.start, *self.goals

    @property
    def constrained(self) -> bool:
        """Whether the pose of a link is constrained on the way."""
        constraints = self.validity.path_constraints
        return constraints is not None and bool(
            constraints.positions or constraints.orientations)

    def ends_free(self, exact: bool, clearance: float = 0.0) -> bool:
        """Return whether start and goals are free."""
        return all(self.validity.free(values, exact, clearance) for values in self.ends)

    def space(self, stage: Stage) -> JointSpace:
        """Return what a search moves in."""
        kind = ConstrainedSpace if self.constrained else JointSpace
        return kind(self.validity, self.start, stage.step, stage.exact, stage.clearance)


def search(problem: SearchProblem, stage: Stage) -> Matrix | None:
    """
    Return the waypoints (k, m) of a path, the shortest of several attempts; None for none.

    :raises PlanningError: PREEMPTED where the request is cancelled.
    """
    if stage.straight:
        return _straight(problem, stage)
    problem = replace(problem, goals=(*problem.goals, *stage.further_goals))
    best: Matrix | None = None
    attempt, most = 0, stage.most_motions
    with_corners = shorter_than = math.inf
    while True:
        attempt += 1
        space = problem.space(stage)
        found = _solve(space, problem, most, shorter_than)
        if found is None:
            return best
        # A second search whose path is the longer one before corners are cut is in vain.
        length = path_length(found)
        if attempt <= problem.attempts or length < with_corners:
            with_corners = min(length, with_corners)
            found = _finished(found, space, problem)
            if best is None or path_length(found) < path_length(best):
                best = found
        if problem.budget.spent():
            return best
        again = (
            attempt == 1 and stage.rough and problem.planner.simplify and best is not None
            and space.motions < _CHEAP_MOTIONS and _is_detour(best)
        )
        if attempt >= problem.attempts:
            if not again or best is None:
                return best
            most, shorter_than = space.motions, path_length(best)


def _straight(problem: SearchProblem, stage: Stage) -> Matrix | None:
    """Return the straight line to the nearest goal that can be reached so, or None."""
    rough = problem.space(stage)
    fine = problem.space(replace(
        stage, exact=True, step=stage.fine_step, clearance=problem.validity.clearance))
    for goal in problem.goals[:_STRAIGHT_GOALS]:
        if problem.constrained or rough.motion_free(problem.start, goal):
            between = fine.join(problem.start, goal)
            if between is not None:
                return np.concatenate([problem.start[None], between, goal[None]])
    return None


def _is_detour(waypoints: Matrix) -> bool:
    straight = float(np.linalg.norm(waypoints[-1] - waypoints[0]))
    return path_length(waypoints) > (1.0 + _DETOUR) * straight


def _solve(
    space: JointSpace, problem: SearchProblem, most_motions: int | None,
    shorter_than: float = math.inf,
) -> Matrix | None:
    """
    Return a path with shortcuts, None where none was found; PREEMPTED where cancelled.

    :param shorter_than: length [rad or m] of the paths that are looked for; others may be found.
    """
    planner, budget = problem.planner, problem.budget

    def stop() -> bool:
        return (most_motions is not None and space.motions > most_motions) or budget.spent()

    if planner.own_search or problem.constrained:
        extension = space.extension
        if planner.own_search:
            extension = float(settings_of(planner, problem.log).get('setRange', extension))
        trees = RRTConnect(space.low, space.high, space.steer, extension, problem.rng)
        found = trees.find(problem.start, problem.goals, stop, shorter_than)
    else:
        found = solve_with_ompl(
            space, planner, problem.start, problem.goals, stop, problem.log)
    budget.check(_SOURCE)
    if found is None:
        return None
    found[0] = problem.start
    found = without_repeats(found)
    if not planner.simplify:
        return found
    return with_shortcuts(found, space, problem.rng, budget.spent)


def _finished(found: Matrix, space: JointSpace, problem: SearchProblem) -> Matrix:
    """Return a path of :func:`_solve` with its corners cut, unless it is to stay as it is."""
    if not problem.planner.simplify:
        return found
    return with_corners_cut(found, space, problem.budget.spent)


def repaired(waypoints: Matrix, problem: SearchProblem, stage: Stage) -> Matrix:
    """
    Return the path with every piece free on exact geometry.

    :param waypoints: (k, m) from start to goal; what is not free of it is searched again, from a
        free waypoint to the next, in fine steps.
    :raises PlanningError: INVALID_MOTION_PLAN where a piece stays blocked; PREEMPTED.
    """
    validity, planner = problem.validity, problem.planner
    closely = replace(stage, step=stage.fine_step)
    pieces: list[Matrix] = [waypoints[:1]]
    changed, a = False, waypoints[0]
    for number, b in enumerate(waypoints[1:], 2):
        if first_blocked(
            np.array([a, b]), validity, stage.fine_step, clearance=0.5 * validity.clearance
        ) is None:
            pieces.append(b[None])
            a = b
            continue
        changed = True
        if number < len(waypoints) and not validity.free(b, stage.exact, stage.clearance):
            continue
        detour = None
        if not problem.budget.spent():
            part = replace(problem, start=a, goals=(b,), planner=planner.for_repairs())
            space = part.space(closely)
            detour = _solve(space, part, _REPAIR_MOTIONS)
            detour = None if detour is None else _finished(detour, space, part)
        if detour is None:
            raise PlanningError(
                MoveItErrorCode.INVALID_MOTION_PLAN,
                f'the path is blocked between {np.round(a, 3).tolist()} and '
                f'{np.round(b, 3).tolist()}', _SOURCE)
        pieces.append(detour[1:])
        a = b
    path = without_repeats(np.concatenate(pieces))
    if changed and planner.simplify:
        space, spent = problem.space(closely), problem.budget.spent
        path = with_corners_cut(
            with_shortcuts(path, space, problem.rng, spent, _LAST_FAILURES), space, spent)
    return without_repeats(path)


def no_path(problem: SearchProblem) -> PlanningError:
    """Return the message where no stage found a path."""
    count = len(problem.goals)
    goals = 'one goal configuration' if count == 1 else f'{count} goal configurations'
    where = np.round(problem.goals[0], 3).tolist()
    code, text = MoveItErrorCode.PLANNING_FAILED, (
        f'gave up before the allowed time was over; no path to {goals} (nearest {where}); try '
        'the planner RRTConnect')
    if problem.budget.spent():
        code, text = MoveItErrorCode.TIMED_OUT, (
            f'found no path to {goals} (nearest {where}) within the allowed time; raise '
            'allowed_planning_time, or check that no object blocks the way')
    return PlanningError(code, f'{problem.planner.name} {text}', _SOURCE)


Motion = tuple[Matrix, QuinticMotion]
"""A path (k, m) and the motion along it."""

FINER = (1.0, 0.5, *(0.25 for _ in range(10)))
"""What the fine step is multiplied with, round by round."""

RESERVE = 2.0
"""No further search begins where less time is left than so many of the longest search so far."""

_FEW_MOTIONS, _MOTIONS = 3000, 8000


def stages(problem: SearchProblem) -> Iterator[Stage]:
    """
    Yield the stages of the search.

    The straight line; hulls with clearance to spare; hulls close by; the shapes themselves in fine
    steps; then the last two again, in finer steps. Hulls are left out where start or goals are
    not free on them or where pose constraints have to be kept. Goals a turn away come in once
    a search has not reached the nearer ones.
    """
    near = problem.validity.clearance
    exact = [Stage(True, near, problem.fine_step * part, problem.fine_step * part)
             for part in FINER]
    if problem.constrained:
        yield replace(exact[0], straight=True)
        turned = problem.turned_goals()
        if turned:
            yield replace(exact[0], most_motions=_MOTIONS)
        for stage in exact:
            yield replace(stage, further_goals=turned)
        return
    coarse = Stage(True, near, SEARCH_STEP, problem.fine_step, _MOTIONS)
    if problem.ends_free(exact=False):
        near = CLEARANCE if problem.ends_free(exact=False, clearance=CLEARANCE) else 0.0
        coarse = replace(coarse, exact=False, clearance=near)
    yield replace(coarse, straight=True)
    if near and problem.ends_free(exact=False, clearance=HULL_CLEARANCE):
        yield replace(coarse, clearance=HULL_CLEARANCE, most_motions=_FEW_MOTIONS)
    yield coarse
    turned = problem.turned_goals()
    coarse = replace(coarse, further_goals=turned)
    if turned:
        yield replace(coarse, most_motions=_FEW_MOTIONS)
    for stage in exact:
        if stage is not exact[0]:
            yield replace(coarse, fine_step=stage.step)
        yield replace(stage, further_goals=turned)


def find_motion(
    problem: SearchProblem, limits: MotionLimits, speed_limit: SpeedLimit | None = None
) -> Motion:
    """
    Return a path and the motion along it, from the first stage whose motion is free.

    A planner that is to use its time (``anytime``) goes on, for a shorter path.

    :param limits: of the joints, which the motion keeps.
    :raises PlanningError: TIMED_OUT, PLANNING_FAILED or PREEMPTED where there is no path;
        INVALID_MOTION_PLAN where no motion along a path is free.
    """
    best = _first_motion(problem, limits, speed_limit)
    longest, budget = 0.0, problem.budget
    while problem.planner.anytime and len(best[0]) > 2 and not budget.spent() and (
        budget.clock() + RESERVE * longest < budget.deadline
    ):
        began = budget.clock()
        try:
            found = _first_motion(problem, limits, speed_limit)
            best = min(best, found, key=lambda motion: path_length(motion[0]))
        except PlanningError as error:
            if error.code == MoveItErrorCode.PREEMPTED:
                raise
        longest = max(longest, budget.clock() - began)
    if problem.planner.anytime:
        budget.check('anytime')
    return best


def _first_motion(
    problem: SearchProblem, limits: MotionLimits, speed_limit: SpeedLimit | None
) -> Motion:
    """Return what the first stage gives whose motion is free."""
    problem.validity.keep_clear(problem.ends)
    failure: PlanningError | None = None
    for stage in stages(problem):
        path = search(problem, stage)
        if path is None:
            if stage.last:
                raise no_path(problem)
            continue
        for rough in (True, False) if stage.rough else (False,):
            # What proves the motion proves the path: most paths need no look of their own.
            try:
                if stage.rough and not rough:
                    path = repaired(path, problem, stage)
                motion = time_waypoints(
                    path, problem.validity, limits, speed_limit, stage.fine_step, rough,
                    max_deviation=min(problem.path_tolerance, MAX_DEVIATION))
            except PlanningError as error:
                if error.code != MoveItErrorCode.INVALID_MOTION_PLAN or (
                    not rough and problem.budget.spent()
                ):
                    raise
                failure = error
            else:
                problem.budget.check('ValidateSolution')
                return path, motion
    raise failure or no_path(problem)
