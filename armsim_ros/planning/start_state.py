# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a motion can begin where it is asked to begin, and what to do where it cannot."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.log import Log
from armsim_ros.planning.budget import Budget
from armsim_ros.planning.collision.state_validity import StateValidity
from armsim_ros.planning.constraints import ConstraintSet
from armsim_ros.planning.context import PlanningContext, PlanningPipeline
from armsim_ros.planning.pilz.joint_sampling import point_to_point
from armsim_ros.planning.request import MotionPlanRequest
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.search.goal_sampling import GoalSampler
from armsim_ros.planning.search.path_search import find_motion, SearchProblem
from armsim_ros.planning.search.planners import PlannerChoice
from armsim_ros.planning.timing.limits import MotionLimits
from armsim_ros.quintic_motion import QuinticMotion

COLLISION = 'FixStartStateCollision'
PATH_CONSTRAINTS = 'FixStartStatePathConstraints'

ROUNDING = 1e-5
"""How far [rad or m] a measured position may lie beyond a limit without a word."""


def requested_scene(
    context: PlanningContext, pipeline: PlanningPipeline, request: MotionPlanRequest,
    scene: PlanningScene,
) -> PlanningScene:
    """
    Return a scene of a request's own with its start state, the group's joints in their limits.

    :param pipeline: the pipeline of the request.
    :raises PlanningError: INVALID_ROBOT_STATE; START_STATE_INVALID with the joint, its value and
        its limits.
    """
    started = context.started(scene, request.start_state)
    group = scene.robot.semantic.groups.get(request.group_name)
    joints = scene.robot.active_joints if group is None else group.active_joints
    started.set_state(_bounded_start(
        started, joints, pipeline.start_state_max_bounds_error, context.log))
    return started


def _bounded_start(
    scene: PlanningScene, joints: Iterable[str], max_bounds_error: float, log: Log
) -> Vector:
    """Return the scene's state (n,) with joints inside their limits, a little repaired."""
    model = scene.kinematic_model
    q = scene.q.copy()
    for name in joints:
        index = model.index(name)
        value, low, high = float(q[index]), float(model.lower[index]), float(model.upper[index])
        beyond = max(low - value, value - high)
        if beyond <= 0.0:
            continue
        if not beyond <= max(max_bounds_error, ROUNDING):
            raise PlanningError(
                MoveItErrorCode.START_STATE_INVALID,
                f"joint '{name}' starts at {value:.5f}, outside its limits {low:.5f} .. "
                f'{high:.5f} by {beyond:.5f}; move the robot back by hand, or allow it with '
                'start_state_max_bounds_error',
                'CheckStartStateBounds')
        q[index] = min(max(value, low), high)
        if beyond > ROUNDING:
            log.warning(
                f"joint '{name}' starts at {value:.5f}, beyond its limit: planning from "
                f'{float(q[index]):.5f}')
    return model.apply_mimic(q)


def check_start(validity: StateValidity, start: Vector) -> None:
    """
    Refuse a start that collides or violates the path constraints.

    :param start: (m,) the group's values.
    :raises PlanningError: START_STATE_IN_COLLISION with the touching pairs, or
        START_STATE_VIOLATES_PATH_CONSTRAINTS with the constraint.
    """
    if validity.collides(start):
        raise PlanningError(
            MoveItErrorCode.START_STATE_IN_COLLISION,
            f'the start state collides: {validity.touching(start)}; move the robot or the '
            'object, or allow the pair in the allowed collision matrix',
            'CheckStartStateCollision', validity.contacts(start))
    if not validity.constrained(start):
        raise PlanningError(
            MoveItErrorCode.START_STATE_VIOLATES_PATH_CONSTRAINTS,
            f'the start state violates the path constraints: {validity.why_not(start)}; move to '
            'a state that keeps them first, or widen them',
            'CheckStartStatePathConstraints')


class StartRepairs:
    """
    Motions from a start that is not valid to a valid state.

    ROS 1's request adapters FixStartStateCollision and FixStartStatePathConstraints; they act
    only where the user names them in ``request_adapters``.

    :param context: what the user set, and the solvers.
    :param pipeline: with the adapters that are named.
    :param request: the motion that is to begin.
    :param limits: of the group's joints, scaled.
    """

    def __init__(
        self, context: PlanningContext, pipeline: PlanningPipeline, request: MotionPlanRequest,
        limits: MotionLimits, rng: np.random.Generator, budget: Budget,
    ) -> None:
        self._pipeline = pipeline
        self._context, self._request, self._limits, self._rng = context, request, limits, rng
        self._budget = budget

    def run(
        self, scene: PlanningScene, validity: StateValidity, start: Vector
    ) -> QuinticMotion:
        """
        Return what to do first: a single point where nothing had to be, or could be, repaired.

        :param start: (m,) the group's values.
        """
        motion = QuinticMotion.at_rest(start)
        wanted = self._pipeline.request_adapters
        if COLLISION in wanted and validity.collides(start):
            free = self._jiggled(validity, start)
            if free is not None:
                motion = point_to_point(start, free, self._limits)
                start = free
        if PATH_CONSTRAINTS in wanted and not validity.constrained(start):
            motion = motion.then(self._to_constraints(scene, validity, start))
        return motion

    def _jiggled(self, validity: StateValidity, start: Vector) -> Vector | None:
        """Return a free state near a colliding state, None where sampling finds none."""
        settings, log = self._pipeline, self._context.log
        low = np.where(np.isfinite(validity.lower), validity.lower, start - np.pi)
        high = np.where(np.isfinite(validity.upper), validity.upper, start + np.pi)
        reach = settings.jiggle_fraction * (high - low)
        for _ in range(settings.max_sampling_attempts):
            near = np.clip(start + self._rng.uniform(-reach, reach), low, high)
            if validity.free(near):
                log.warning(
                    f'the start state collides ({validity.touching(start)}): moving out of it '
                    f'first, by at most {float(np.max(np.abs(near - start))):.4f} in a joint')
                return near
        log.warning(
            f'the start state collides and none of {settings.max_sampling_attempts} states '
            f'within {settings.jiggle_fraction:g} of the joint ranges is free')
        return None

    def _to_constraints(
        self, scene: PlanningScene, validity: StateValidity, start: Vector
    ) -> QuinticMotion:
        """Return a motion to the nearest state found that keeps the path constraints."""
        context, group = self._context, self._request.group_name
        unbound = context.validity(scene, group)
        began = context.model.insert(scene.q, group, start)
        kept = ConstraintSet(self._request.path_constraints, scene, context.log)
        sampler = GoalSampler(
            context.model, context.inverse(group), unbound, began, self._rng)
        goals = sampler.sample([kept], self._budget)
        problem = SearchProblem(
            unbound, start, tuple(goals), PlannerChoice(), self._rng, self._budget, context.log,
            context.settings.fine_step)
        _, motion = find_motion(problem, self._limits)
        context.log.warning(
            f'the start state violates the path constraints ({validity.why_not(start)}): moving '
            'to a state that keeps them first')
        return motion
