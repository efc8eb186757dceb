# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The planning pipeline: from a request to a timed trajectory, stage by stage."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from armsim_ros.errors import PlanningError
from armsim_ros.planning.anytime import shortest_in_time
from armsim_ros.planning.constraints import ConstraintSet, merged
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.error_codes import MoveItErrorCode
from armsim_ros.planning.goal_sampling import GoalSampler
from armsim_ros.planning.ompl_space import seed_search
from armsim_ros.planning.path_timing import time_rough_path, time_waypoints
from armsim_ros.planning.pilz.commands import PIPELINE as PILZ
from armsim_ros.planning.pilz.commands import run_command
from armsim_ros.planning.quintic import QuinticMotion
from armsim_ros.planning.request import Constraints, MotionPlanRequest
from armsim_ros.planning.request_checks import RequestChecks
from armsim_ros.planning.scene import PlanningScene
from armsim_ros.planning.search import Budget, find_rough_path, mended, SearchProblem
from armsim_ros.planning.smoothing import path_length
from armsim_ros.planning.start_repairs import joined, StartRepairs
from armsim_ros.planning.start_state import bounded_start, check_start
from armsim_ros.trajectory import JointTrajectory, TrajectoryPoint

Vector = NDArray[np.float64]

_AT_REST = 1e-6
_FINER = (1.0, 0.5, *(0.25 for _ in range(10)))


def run_pipeline(
    context: PlanningContext, request: MotionPlanRequest, scene: PlanningScene, budget: Budget
) -> tuple[JointTrajectory, float]:
    """
    Run every stage in order; each raises PlanningError where it cannot go on.

    :param scene: what to plan in, of the request alone; its state is the start.
    :param budget: ends at the request's allowed planning time.
    :returns: the trajectory, and its path's length [rad or m].
    """
    checks = RequestChecks(context.model, context.settings, context.log)
    group = checks.group(request.group_name)
    checks.pipeline(request)
    if (request.pipeline_id or context.settings.default_pipeline) == PILZ:
        return run_command(context, request, scene, budget)
    seed = request.seed if request.seed >= 0 else context.settings.seed
    rng = np.random.default_rng(seed if seed >= 0 else None)
    if seed >= 0:
        seed_search(seed)

    on_path = ConstraintSet(request.path_constraints, scene, context.log)
    validity = context.validity(scene, group, on_path)
    start = context.model.extract(scene.q, group)
    limits = checks.limits(context.limits, validity.joint_names, request)
    repairs = StartRepairs(context, request, limits, rng, budget)
    first, start = repairs.run(scene, validity, start)
    if first:
        scene.set_state(context.model.insert(scene.q, group, start))
        validity = context.validity(scene, group, on_path)
    check_start(validity, start)

    sampler = GoalSampler(context.model, context.inverse(group), validity, scene.q, rng)
    states = sampler.sample(_goal_sets(context, request, scene), budget)
    if float(np.max(np.abs(states[0] - start))) < _AT_REST:
        return joined([*first, _standing(start, validity.joint_names)]), 0.0

    speed_limit = checks.speed_limit(request, validity, group)
    planner = context.settings.planners.choose(request.planner_id, group, context.log)
    attempts = checks.attempts(request)

    def search(step: float) -> tuple[Vector, QuinticMotion]:
        problem = SearchProblem(validity, start, tuple(states), planner, rng, step)
        path, exact = find_rough_path(problem, budget, attempts, context.log)
        motion = None if exact else time_rough_path(path, validity, limits, speed_limit, step)
        if motion is None:
            path = path if exact else mended(path, problem, budget, context.log)
            motion = time_waypoints(path, validity, limits, speed_limit, step)
        budget.check('ValidateSolution')
        return path, motion

    path, motion = _with_finer_steps(search, context.settings.fine_step, budget)
    if planner.anytime and len(path) > 2:
        path, motion = shortest_in_time(
            (path, motion), lambda: search(context.settings.fine_step), budget)
    return joined([*first, motion.trajectory(validity.joint_names)]), path_length(path)


def _with_finer_steps(
    search: Callable[[float], tuple[Vector, QuinticMotion]], step: float, budget: Budget
) -> tuple[Vector, QuinticMotion]:
    """Search again, in finer steps, where the motion that was found is not free."""
    for finer in _FINER:
        try:
            return search(step * finer)
        except PlanningError as error:
            if error.code != MoveItErrorCode.INVALID_MOTION_PLAN or budget.spent():
                raise
            failure = error
    raise failure


def requested_scene(
    context: PlanningContext, request: MotionPlanRequest, scene: PlanningScene
) -> PlanningScene:
    """
    Return the scene with the request's start state in it, joints inside their limits.

    :raises PlanningError: INVALID_ROBOT_STATE or START_STATE_INVALID.
    """
    settings = context.settings
    started = scene.with_start_state(request.start_state, strict=settings.strict_start_state)
    started.set_state(bounded_start(started, settings.start_state_max_bounds_error, context.log))
    return started


def _goal_sets(
    context: PlanningContext, request: MotionPlanRequest, scene: PlanningScene
) -> list[ConstraintSet]:
    """Return the alternatives that can be used; joint path constraints narrow each."""
    joints = Constraints(joint_constraints=request.path_constraints.joint_constraints)
    usable = []
    reasons: list[str] = []
    for goal in request.goal_constraints:
        if goal.empty:
            continue
        made = ConstraintSet(merged(goal, joints, context.log), scene, context.log)
        reasons += made.dropped
        if not made.empty:
            usable.append(made)
    if not usable:
        raise PlanningError(
            MoveItErrorCode.INVALID_GOAL_CONSTRAINTS,
            'the request has no usable goal constraint: '
            + ('; '.join(reasons) or 'goal_constraints is empty'),
            'goal constraints',
        )
    return usable


def _standing(start: Vector, joint_names: tuple[str, ...]) -> JointTrajectory:
    zero = np.zeros(len(start))
    return JointTrajectory(joint_names, (TrajectoryPoint(0.0, start, zero, zero),))
