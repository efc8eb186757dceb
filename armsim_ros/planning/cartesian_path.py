# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Paths on which a link moves straight between waypoints: followed, cut at jumps, timed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import MoveItErrorCode, nearest, PlanningError
from armsim_ros.planning.cartesian_curves import CurveFollower, Line
from armsim_ros.planning.collision.state_validity import StateValidity
from armsim_ros.planning.constraint_terms import Frame
from armsim_ros.planning.constraints import ConstraintSet
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.request import CartesianRequest, CartesianResponse, is_place
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.search.shortening import without_repeats
from armsim_ros.planning.timing.limits import link_speed_limit
from armsim_ros.planning.timing.path_timing import time_waypoints
from armsim_ros.planning.timing.time_parameterization import BlendedPath, time_path
from armsim_ros.quintic_motion import QuinticMotion
from armsim_ros.trajectory import JointTrajectory

ROTATION_PER_STEP = 3.5
"""Turn [rad] that counts as much as a metre of ``max_step``."""

MOST_STATES = 5000
"""A request whose ``max_step`` asks for more states gets a larger step."""

_POSITION_PRECISION = 1e-3
_ROTATION_PRECISION = 1e-2
_LEAST_WIDTH = 1e-5


class CartesianPath:
    """
    Joint states along straight lines and even rotations, as far as inverse kinematics goes.

    Every state that inverse kinematics finds is checked, and the motions between those that are
    free; the start state is not.

    :param follower: takes the frame from pose to pose.
    :param validity: checks states and the motions between them.
    :param start: (m,) of the group.
    :param total: number of waypoints.
    :param step: largest motion [m] of any point between two checks.
    """

    def __init__(
        self, follower: CurveFollower, validity: StateValidity, start: Vector, total: int,
        step: float,
    ) -> None:
        self._follower, self._validity, self._total, self._step = follower, validity, total, step
        self._from_free = validity.free(start)
        #: (m,) each; the first is the start.
        self.states = [start]
        #: Covered part of the path, 0..1, in whole steps.
        self.fraction = 0.0
        #: Why it ends early, '' where it does not.
        self.reason = ''

    def follow(self, waypoints: Sequence[Matrix], max_step: float, *, relative: bool) -> None:
        """
        Add states through poses (4, 4) in the model frame.

        :param max_step: between two states [m].
        :param relative: each pose is relative to the pose before it.
        """
        here = self._follower.pose(self.states[0])
        for number, waypoint in enumerate(waypoints):
            target = here @ waypoint if relative else waypoint
            segment = Line(here, target)
            parts = math.floor(
                max(segment.length / max_step, segment.angle / (ROTATION_PER_STEP * max_step))
            ) + 1
            values = self.states[-1]
            for part in range(parts):
                self._validity.poll()
                low, high = part / parts, (part + 1) / parts
                last, found = values, self._solved(segment.pose(high), values)
                if found is None or not self._refined(segment, last, found, low, high):
                    self.reason = (
                        f'waypoint {number + 1}, {high:.0%} of its segment: {self.reason}')
                    return
                values = found
                self.fraction = (number + high) / self._total
            here = target

    def _solved(self, pose: Matrix, start: Vector) -> Vector | None:
        """Return the valid state at a pose, None with :attr:`reason` where there is none."""
        values, result = self._follower.solve(pose, start)
        if values is None:
            self.reason = result.message
        elif not self._validity.free(values):
            self.reason = self._validity.why_not(values)
            return None
        return values

    def _refined(
        self, segment: Line, first: Vector, last: Vector, low: float, high: float
    ) -> bool:
        """Add the state at ``high``, and others before it until the middles are on the path."""
        middle = 0.5 * (low + high)
        if self._straight(first, last, segment.pose(middle)):
            if self._from_free and not self._validity.motion_free(first, last, self._step):
                self.reason = self._validity.why_not(last) or 'something is in between'
                return False
            self._from_free = True
            self.states.append(last)
            return True
        if high - low < _LEAST_WIDTH:
            self.reason = 'the joints would have to jump'
            return False
        between = self._solved(segment.pose(middle), 0.5 * (first + last))
        return between is not None and (
            self._refined(segment, first, between, low, middle)
            and self._refined(segment, between, last, middle, high))

    def _straight(self, first: Vector, second: Vector, wanted: Matrix) -> bool:
        """Return whether the joint motion's middle is on the Cartesian path."""
        off, turned = self._follower.distance(0.5 * (first + second), wanted)
        return off <= _POSITION_PRECISION and turned <= _ROTATION_PRECISION


MAX_DEVIATION = 0.002
"""Largest distance [rad or m] in joint space between a corner and its blend."""

_SOURCE = 'compute_cartesian_path'


def plan_cartesian(
    context: PlanningContext, request: CartesianRequest, scene: PlanningScene,
    cancelled: Callable[[], bool],
) -> CartesianResponse:
    """Return the feasible part of a path; a shorter path is a success with a fraction below 1."""
    start: dict[str, float] = {}

    def poll() -> None:
        if cancelled():
            raise PlanningError(
                MoveItErrorCode.PREEMPTED, 'the request was cancelled', _SOURCE)

    try:
        context.model.group_indices(request.group_name)
        if not request.max_step > 1e-9 or not np.isfinite(request.max_step):
            raise PlanningError(
                MoveItErrorCode.FAILURE,
                f'max_step is {request.max_step:g}; give a distance above 0, e.g. 0.01', _SOURCE)
        if not request.waypoints:
            return CartesianResponse(MoveItErrorCode.SUCCESS)
        present, scene = scene, context.started(scene, request.start_state)
        start = context.model.positions(scene.q)
        on_path = ConstraintSet(request.path_constraints, scene, context.log)
        with context.polled(poll):
            validity = context.validity(
                scene, request.group_name, on_path, request.avoid_collisions)
        path = _followed(context, request, present, scene, validity)
        trajectory = _timed(context, request, validity, path)
    except PlanningError as error:
        context.log.error(f'{_SOURCE}: {error}')
        return CartesianResponse(
            MoveItErrorCode(error.code), str(error), error.source or _SOURCE, start=start)
    if path.reason:
        context.log.info(f'{_SOURCE}: {path.fraction:.1%} of the path: {path.reason}')
    reason = '; '.join(filter(None, (path.reason, scene.refused)))
    return CartesianResponse(
        MoveItErrorCode.SUCCESS, reason, _SOURCE if reason else '', trajectory,
        path.fraction, start)


def _followed(
    context: PlanningContext, request: CartesianRequest, present: PlanningScene,
    scene: PlanningScene, validity: StateValidity,
) -> CartesianPath:
    group = request.group_name
    name = request.link_name or context.model.robot.semantic.groups[group].links[-1]
    found = scene.robot_frame(name)
    if found is None:
        raise PlanningError(
            MoveItErrorCode.INVALID_LINK_NAME,
            f"'{name}' is not a link, an attached object or its subframe "
            f'{nearest(name, tuple(context.model.robot.links))}'.rstrip(), _SOURCE)
    if not all(map(is_place, request.waypoints)):
        raise PlanningError(
            MoveItErrorCode.FAILURE, 'a waypoint has a number that is not finite or too large',
            _SOURCE)
    frame = Frame(*found)
    relative = request.frame_id == name
    waypoints = request.waypoints
    if relative:
        moves = [Line(np.eye(4), waypoint) for waypoint in waypoints]
    else:
        base = present.transform(request.frame_id)
        waypoints = tuple(base @ waypoint for waypoint in waypoints)
        here = scene.frame_pose(frame.link) @ frame.offset
        moves = [Line(first, last) for first, last in pairwise((here, *waypoints))]
    path = CartesianPath(
        CurveFollower(context, validity, frame), validity, context.model.extract(scene.q, group),
        len(waypoints), context.settings.fine_step)
    try:
        context.solver_target(scene, group, name)
    except PlanningError as error:
        path.reason = str(error)
    else:
        path.follow(waypoints, _step(context, request.max_step, moves), relative=relative)
    return path


def _step(context: PlanningContext, step: float, moves: Sequence[Line]) -> float:
    """Return the largest distance between two states [m], so that they are not too many."""
    length = sum(max(move.length, move.angle / ROTATION_PER_STEP) for move in moves)
    if length / step <= MOST_STATES:
        return step
    context.log.warning(
        f'{_SOURCE}: max_step {step:g} m would make more than {MOST_STATES} states; '
        f'using {length / MOST_STATES:.4g} m, the path is as precise')
    return length / MOST_STATES


def _timed(
    context: PlanningContext, request: CartesianRequest, validity: StateValidity,
    path: CartesianPath,
) -> JointTrajectory:
    waypoints = without_repeats(path.states, 1e-6)
    if len(waypoints) < 2:
        return QuinticMotion.at_rest(path.states[0]).trajectory(validity.joint_names)
    limits = context.limits.requested(validity.joint_names, request)
    speed_limit = link_speed_limit(context.model, validity, request)
    if validity.free(waypoints[0]) and validity.within_limits(waypoints[0]):
        motion = time_waypoints(
            waypoints, validity, limits, speed_limit, context.settings.fine_step,
            max_deviation=MAX_DEVIATION)
    else:
        deviation = np.full(len(waypoints) - 2, MAX_DEVIATION)
        motion = time_path(BlendedPath(waypoints, deviation), limits, speed_limit)
    return motion.trajectory(validity.joint_names)
