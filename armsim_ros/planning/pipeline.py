# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The planning pipeline: from a request to a timed trajectory, stage by stage."""

from __future__ import annotations

import math

import numpy as np

from armsim_ros.config.ompl_planning import Planner
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.log import DelayedLog
from armsim_ros.planning.budget import Budget
from armsim_ros.planning.constraints import ConstraintSet, merged
from armsim_ros.planning.context import PlanningContext, PlanningPipeline
from armsim_ros.planning.pilz.commands import run_command
from armsim_ros.planning.request import Constraints, MotionPlanRequest
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.search.goal_sampling import GoalSampler
from armsim_ros.planning.search.ompl_interface import seed_search
from armsim_ros.planning.search.path_search import find_motion, SearchProblem
from armsim_ros.planning.search.shortening import path_length
from armsim_ros.planning.start_state import check_start, StartRepairs
from armsim_ros.planning.timing.limits import link_speed_limit
from armsim_ros.trajectory import JointTrajectory

LONGEST_PLANNING_TIME = 600.0
"""The most that a request gets [s]."""

_AT_REST = 1e-6
_SOURCE = 'planning pipeline'
_DEFAULT_TIME = 1.0


def run_pipeline(
    context: PlanningContext, pipeline: PlanningPipeline, request: MotionPlanRequest,
    present: PlanningScene, scene: PlanningScene, budget: Budget,
) -> tuple[JointTrajectory, float]:
    """
    Run every stage in order; each raises PlanningError where it cannot go on.

    :param pipeline: the pipeline of the request.
    :param present: the monitored scene.
    :param scene: what to plan in, of the request alone; its state is the start.
    :param budget: ends at the request's allowed planning time.
    :returns: the trajectory, and its path's length [rad or m].
    """
    group = request.group_name
    _check_trajectory_constraints(context, pipeline, request)
    if 'CheckForStackedConstraints' in pipeline.request_adapters:
        _warn_of_stacked(context, request)
    if pipeline.planner is Planner.PILZ:
        return run_command(context, request, present, scene, budget)
    _check_group(context, group)
    seed = request.seed if request.seed >= 0 else context.settings.seed
    rng = np.random.default_rng(seed if seed >= 0 else None)
    if seed >= 0:
        seed_search(seed)

    on_path = ConstraintSet(request.path_constraints, scene, context.log)
    validity = context.validity(scene, group, on_path)
    start = context.model.extract(scene.q, group)
    limits = context.limits.requested(validity.joint_names, request)
    repairs = StartRepairs(context, pipeline, request, limits, rng, budget)
    first = repairs.run(scene, validity, start)
    if first.duration:
        start = first.positions[-1]
        scene.set_state(context.model.insert(scene.q, group, start))
        validity = context.validity(scene, group, on_path)
    check_start(validity, start)

    sampler = GoalSampler(context.model, context.inverse(group), validity, scene.q, rng)
    goals = _goal_sets(context, request, scene)
    states = sampler.sample(goals, budget)
    if float(np.max(np.abs(states[0] - start))) < _AT_REST:
        return first.trajectory(validity.joint_names), 0.0

    speed_limit = link_speed_limit(context.model, validity, request)
    planner = pipeline.planners.choose(request.planner_id, group, context.log)
    problem = SearchProblem(
        validity, start, tuple(states), planner, rng, budget, context.log,
        context.settings.fine_step, _attempts(context, request),
        pipeline.path_tolerance, lambda: sampler.turned(goals, states))
    path, motion = find_motion(problem, limits, speed_limit)
    return first.then(motion).trajectory(validity.joint_names), path_length(path)


def _goal_sets(
    context: PlanningContext, request: MotionPlanRequest, scene: PlanningScene
) -> list[ConstraintSet]:
    """Return the alternatives that can be used; joint path constraints narrow each."""
    joints = Constraints(joint_constraints=request.path_constraints.joint_constraints)
    usable = []
    reasons: list[str] = []
    log = DelayedLog()
    for goal in request.goal_constraints:
        if goal.empty:
            continue
        made = ConstraintSet(merged(goal, joints, log), scene, log)
        reasons += made.unusable
        if made.satisfiable and not made.empty:
            usable.append(made)
    if not usable:
        raise PlanningError(
            MoveItErrorCode.INVALID_GOAL_CONSTRAINTS,
            'the request has no usable goal constraint: '
            + ('; '.join(reasons) or 'goal_constraints is empty'),
            'goal constraints')
    log.pass_to(context.log)
    return usable


def _warn_of_stacked(context: PlanningContext, request: MotionPlanRequest) -> None:
    """Warn of several constraints of a kind."""
    path, goals = request.path_constraints, request.goal_constraints
    for kind, parts in (('path', (path,)), ('goal', goals)):
        if any(len(part.position_constraints) > 1 or len(part.orientation_constraints) > 1
               for part in parts):
            context.log.warning(
                f'the {kind} constraints have more than one position or orientation constraint; '
                'is a pose target left from an earlier request (clearPoseTargets())?')


def _check_group(context: PlanningContext, name: str) -> None:
    """Raise INVALID_GROUP_NAME where a group is unknown or cannot move."""
    if not len(context.model.group_indices(name)):
        raise PlanningError(
            MoveItErrorCode.INVALID_GROUP_NAME,
            f"planning group '{name}' has no joint that can be moved", _SOURCE)


def _check_trajectory_constraints(
    context: PlanningContext, pipeline: PlanningPipeline, request: MotionPlanRequest
) -> None:
    """Refuse what no planner here uses, or warn of it where upstream plans without it."""
    if request.has_trajectory_constraints:
        reason = 'trajectory_constraints are not supported; use path_constraints'
        if pipeline.planner is Planner.PILZ:
            raise PlanningError(MoveItErrorCode.PLANNING_FAILED, reason, _SOURCE)
        context.log.warning(f'{reason}: planning without them')


def planning_time(context: PlanningContext, request: MotionPlanRequest) -> float:
    """Return the time for the search [s]."""
    wanted = request.allowed_planning_time
    if LONGEST_PLANNING_TIME < wanted < math.inf:
        context.log.warning(
            f'allowed_planning_time is {wanted:g} s: using {LONGEST_PLANNING_TIME:g} s, as '
            'others wait meanwhile')
        return LONGEST_PLANNING_TIME
    if 0.0 < wanted < math.inf:
        return wanted
    context.log.info(
        f'allowed_planning_time is {request.allowed_planning_time:g}: using {_DEFAULT_TIME} s')
    return _DEFAULT_TIME


def _attempts(context: PlanningContext, request: MotionPlanRequest) -> int:
    """Return how often to search."""
    if request.num_planning_attempts < 0:
        context.log.error(
            f'num_planning_attempts is {request.num_planning_attempts}: using 1')
    return max(1, request.num_planning_attempts)
