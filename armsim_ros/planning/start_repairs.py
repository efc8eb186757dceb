# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Ways out of a start state that no plan may begin with.

ROS 1's request adapters FixStartStateCollision and FixStartStatePathConstraints; they act only
where the user names them in ``request_adapters``.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from armsim_ros.planning.constraints import ConstraintSet
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.goal_sampling import GoalSampler
from armsim_ros.planning.limits import MotionLimits
from armsim_ros.planning.path_timing import time_waypoints
from armsim_ros.planning.pilz.profile import point_to_point
from armsim_ros.planning.planners import PlannerChoice
from armsim_ros.planning.request import MotionPlanRequest
from armsim_ros.planning.scene import PlanningScene
from armsim_ros.planning.search import Budget, find_path, SearchProblem
from armsim_ros.planning.state_validity import StateValidity
from armsim_ros.trajectory import JointTrajectory, TrajectoryPoint

Vector = NDArray[np.float64]

COLLISION = 'FixStartStateCollision'
PATH_CONSTRAINTS = 'FixStartStatePathConstraints'

_STEP = 0.1


class StartRepairs:
    """
    Motions from a start that is not valid to one that is.

    :param context: what the user set, and the solvers.
    :param request: the motion that is to begin.
    :param limits: of the group's joints, scaled.
    """

    def __init__(
        self, context: PlanningContext, request: MotionPlanRequest, limits: MotionLimits,
        rng: np.random.Generator, budget: Budget,
    ) -> None:
        """Keep the parts."""
        self._context = context
        self._request = request
        self._limits = limits
        self._rng = rng
        self._budget = budget

    def run(
        self, scene: PlanningScene, validity: StateValidity, start: Vector
    ) -> tuple[list[JointTrajectory], Vector]:
        """
        Return what to do first, and where that ends.

        :param start: (m,) the group's values.
        :returns: an empty list where nothing had to be, or could be repaired.
        """
        motions: list[JointTrajectory] = []
        wanted = self._context.settings.start_repairs
        if COLLISION in wanted and validity.collides(start):
            free = self._jiggled(validity, start)
            if free is not None:
                motion = point_to_point(start, free, self._limits, _STEP)
                motions.append(motion.trajectory(validity.joint_names))
                start = free
        if PATH_CONSTRAINTS in wanted and not validity.constrained(start):
            states = self._to_constraints(scene, validity, start)
            motions.append(states)
            start = states.points[-1].positions
        return motions, start

    def _jiggled(self, validity: StateValidity, start: Vector) -> Vector | None:
        """Return a free state near a colliding one, None where chance finds none."""
        settings, log = self._context.settings, self._context.log
        low = np.where(np.isfinite(validity.lower), validity.lower, start - np.pi)
        high = np.where(np.isfinite(validity.upper), validity.upper, start + np.pi)
        reach = settings.jiggle_fraction * (high - low)
        for _ in range(settings.max_sampling_attempts):
            near = np.clip(start + self._rng.uniform(-reach, reach), low, high)
            if validity.free(near):
                log.warning(
                    f'the start state collides ({validity.touching(start)}): moving out of it '
                    f'first, by at most {float(np.max(np.abs(near - start))):.4f} in a joint'
                )
                return near
        log.warning(
            f'the start state collides and none of {settings.max_sampling_attempts} states '
            f'within {settings.jiggle_fraction:g} of the joint ranges is free'
        )
        return None

    def _to_constraints(
        self, scene: PlanningScene, validity: StateValidity, start: Vector
    ) -> JointTrajectory:
        """Return a motion to the nearest state found that keeps the path constraints."""
        context, group = self._context, self._request.group_name
        unbound = context.validity(scene, group)
        began = context.model.insert(scene.q, group, start)
        kept = ConstraintSet(self._request.path_constraints, scene, context.log)
        sampler = GoalSampler(
            context.model, context.inverse(group), unbound, began, self._rng
        )
        goals = sampler.sample([kept], self._budget)
        problem = SearchProblem(
            unbound, start, tuple(goals), PlannerChoice(), self._rng, context.settings.fine_step
        )
        path = find_path(problem, self._budget, 1, context.log)
        context.log.warning(
            f'the start state breaks the path constraints ({validity.why_not(start)}): moving '
            'to a state that keeps them first'
        )
        motion = time_waypoints(path, unbound, self._limits, None, context.settings.fine_step)
        return motion.trajectory(validity.joint_names)


def joined(motions: Sequence[JointTrajectory]) -> JointTrajectory:
    """Return motions that begin where the one before ends, at rest, as one."""
    points: list[TrajectoryPoint] = []
    offset = 0.0
    for motion in motions:
        for point in motion.points[1 if points else 0:]:
            points.append(TrajectoryPoint(
                offset + point.time_from_start, point.positions, point.velocities,
                point.accelerations,
            ))
        offset = points[-1].time_from_start
    return JointTrajectory(motions[0].joint_names, tuple(points))
