# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Paths on which a link moves straight between waypoints: followed, cut at jumps, timed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.model.robot_model import JointType
from armsim_ros.planning.cartesian.curves import CurveFollower, Line
from armsim_ros.planning.collision.state_validity import StateValidity
from armsim_ros.planning.constraints import ConstraintSet, Frame
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.request import CartesianRequest, CartesianResponse, is_place
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.search.shortening import without_repeats
from armsim_ros.planning.start_state import requested_scene
from armsim_ros.planning.timing.limits import link_speed_limit
from armsim_ros.planning.timing.path_timing import time_waypoints
from armsim_ros.quintic_motion import QuinticMotion
from armsim_ros.trajectory import JointTrajectory

ROTATION_PER_STEP = 3.5
"""Turn [rad] that counts as much as one metre of ``max_step``."""

MOST_STATES = 5000
"""A request whose ``max_step`` asks for more states gets a larger step."""

_POSITION_PRECISION = 1e-3
_ROTATION_PRECISION = 1e-2
_MIN_PART = 1e-5
_FARTHEST = 1.5


class CartesianPath:
    """
    Joint states along straight lines and even rotations, as far as inverse kinematics goes.

    :param follower: takes the frame from pose to pose.
    :param validity: judges every state and the motions between them.
    :param start: (m,) of the group.
    :param total: number of waypoints.
    :param step: largest motion [m] of any point between two checks.
    """

    def __init__(
        self, follower: CurveFollower, validity: StateValidity, start: Vector, total: int,
        step: float,
    ) -> None:
        self._follower = follower
        self._validity = validity
        self._total = total
        self._step = step
        #: (m,) each; the first is the start.
        self.states = [start]
        #: How much of the path each state has covered, in waypoints.
        self.places = [0.0]
        #: Why it ends early, '' where it does not.
        self.reason = ''

    @property
    def fraction(self) -> float:
        """Covered part of the path, 0..1."""
        return min(1.0, self.places[-1] / self._total)

    def follow(self, waypoints: Sequence[Matrix], max_step: float, *, relative: bool) -> None:
        """
        Add states through poses (4, 4) in the model frame.

        :param max_step: between two states [m].
        :param relative: each pose is relative to the pose before it.
        """
        wrong = '' if self._validity.free(self.states[0]) else (
            self._validity.why_not(self.states[0]))
        if wrong:
            self.reason = f'the start state is not valid: {wrong}'
            return
        here = self._follower.pose(self.states[0])
        for number, waypoint in enumerate(waypoints):
            target = here @ waypoint if relative else waypoint
            segment = Line(here, target)
            turn = 0.0 if self._follower.position_only else segment.angle
            parts = math.floor(
                max(segment.length / max_step, turn / (ROTATION_PER_STEP * max_step))
            ) + 1
            for part in range(parts):
                self._validity.poll()
                self._advance(segment, number, part / parts, (part + 1) / parts)
                if self.reason:
                    return
            here = target

    def _advance(self, segment: Line, number: int, low: float, high: float) -> None:
        """Add the state at part ``high`` of a segment, and others before it where needed."""
        last = self.states[-1]
        values, result = self._follower.solve(segment.pose(high), *self._starts(number + high))
        middle = 0.5 * (low + high)
        shortest, wrong = _MIN_PART, ''
        if values is None:
            shortest, wrong = 64.0 * _MIN_PART, result.message
        elif not self._straight(last, values, segment.pose(middle)):
            wrong = 'the joints would have to jump'
        if wrong and high - low > shortest:
            self._advance(segment, number, low, middle)
            if not self.reason:
                self._advance(segment, number, middle, high)
            return
        if values is not None and not wrong and not self._validity.motion_free(
            last, values, self._step
        ):
            wrong = self._validity.why_not(values) or 'something is in between'
        if values is None or wrong:
            self.reason = f'waypoint {number + 1}, {high:.0%} of its segment: {wrong}'
            return
        self.states.append(values)
        self.places.append(number + high)

    def _starts(self, place: float) -> list[Vector]:
        """Return where the state at the next place may be near: straight on, or the last one."""
        last = self.states[-1]
        if len(self.states) < 2:
            return [last]
        rate = (place - self.places[-1]) / max(self.places[-1] - self.places[-2], _MIN_PART)
        if rate > _FARTHEST:
            return [last]
        return [last + rate * (last - self.states[-2]), last]

    def _straight(self, first: Vector, second: Vector, wanted: Matrix) -> bool:
        """Return whether the joint motion's middle lies on the Cartesian path."""
        off, turned = self._follower.distance(0.5 * (first + second), wanted)
        return off <= _POSITION_PRECISION and turned <= _ROTATION_PRECISION

    def cut_at_jump(self, request: CartesianRequest, joint_types: Sequence[JointType]) -> None:
        """
        End before the first joint step that is larger than the request allows.

        The relative threshold compares joint motion per distance covered with its mean.

        :param joint_types: of the group's variables.
        """
        if len(self.states) < 2:
            return
        steps = np.diff(self.states, axis=0)
        covered = np.maximum(np.diff(self.places), 1e-12)
        rates = np.linalg.norm(steps, axis=1) / covered
        limits = np.array([
            request.prismatic_jump_threshold if kind is JointType.PRISMATIC
            else request.revolute_jump_threshold for kind in joint_types
        ])
        limits = np.where(limits > 0.0, limits, math.inf)
        jumps = np.any(np.abs(steps) > limits, axis=1)
        if request.jump_threshold > 0.0:
            mean = float(np.sum(rates * covered) / np.sum(covered))
            jumps |= rates > request.jump_threshold * mean * (1.0 + 1e-9)
        if jumps.any():
            first = int(np.argmax(jumps))
            largest = float(np.max(np.abs(steps[first])))
            del self.states[first + 1:], self.places[first + 1:]
            self.reason = f'a joint would jump by {largest:.4f}, more than the threshold'


MAX_DEVIATION = 0.002
"""Largest distance [rad or m] in joint space between a corner and its blend."""

_SOURCE = 'compute_cartesian_path'


def plan_cartesian(
    context: PlanningContext, request: CartesianRequest, scene: PlanningScene,
    cancelled: Callable[[], bool],
) -> CartesianResponse:
    """Return the feasible part of a path; a shorter one is a success with a fraction below 1."""
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
                f'max_step is {request.max_step:g}; give a distance above 0, e.g. 0.01', _SOURCE,
            )
        if not request.waypoints:
            return CartesianResponse(MoveItErrorCode.SUCCESS)
        scene = requested_scene(context, request.start_state, scene)
        start = context.model.positions(scene.q)
        on_path = ConstraintSet(request.path_constraints, scene, context.log)
        with context.polled(poll):
            validity = context.validity(
                scene, request.group_name, on_path, request.avoid_collisions
            )
        path = _followed(context, request, scene, validity)
        trajectory = _timed(context, request, validity, path)
    except PlanningError as error:
        context.log.error(f'{_SOURCE}: {error}')
        return CartesianResponse(
            MoveItErrorCode(error.code), str(error), error.source or _SOURCE, start=start
        )
    if path.reason:
        context.log.info(f'{_SOURCE}: {path.fraction:.1%} of the path: {path.reason}')
    return CartesianResponse(
        MoveItErrorCode.SUCCESS, path.reason, _SOURCE if path.reason else '', trajectory,
        path.fraction, start,
    )


def _followed(
    context: PlanningContext, request: CartesianRequest, scene: PlanningScene,
    validity: StateValidity,
) -> CartesianPath:
    group = request.group_name
    name = request.link_name or context.tip(group)
    try:
        frame = Frame(*scene.link_of_frame(name))
    except PlanningError as error:
        raise PlanningError(MoveItErrorCode.INVALID_LINK_NAME, str(error), _SOURCE) from None
    if frame.link not in context.model.moved_links(group):
        raise PlanningError(
            MoveItErrorCode.INVALID_LINK_NAME,
            f"group '{group}' does not move link '{name}'", _SOURCE,
        )
    if not all(map(is_place, request.waypoints)):
        raise PlanningError(
            MoveItErrorCode.FAILURE, 'a waypoint has a number that is not finite or too large',
            _SOURCE,
        )
    relative = bool(request.frame_id) and request.frame_id == name
    waypoints = request.waypoints
    if relative:
        moves = [Line(np.eye(4), waypoint) for waypoint in waypoints]
    else:
        base = scene.frame_pose(request.frame_id, scene.q)
        waypoints = tuple(base @ waypoint for waypoint in waypoints)
        here = scene.frame_pose(frame.link) @ frame.offset
        moves = [Line(first, last) for first, last in pairwise((here, *waypoints))]
    path = CartesianPath(
        CurveFollower(context, validity, frame), validity, context.model.extract(scene.q, group),
        len(waypoints), context.settings.fine_step)
    path.follow(waypoints, _step(context, request.max_step, moves), relative=relative)
    joints = context.model.robot.joints
    path.cut_at_jump(request, [joints[name].type for name in validity.joint_names])
    return path


def _step(context: PlanningContext, step: float, moves: Sequence[Line]) -> float:
    """Return the largest distance between two states [m], so that they are not too many."""
    length = sum(max(move.length, move.angle / ROTATION_PER_STEP) for move in moves)
    if length / step <= MOST_STATES:
        return step
    context.log.warning(
        f'{_SOURCE}: max_step {step:g} m would make more than {MOST_STATES} states; '
        f'using {length / MOST_STATES:.4g} m, the path is as precise'
    )
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
    motion = time_waypoints(
        waypoints, validity, limits, speed_limit, context.settings.fine_step,
        max_deviation=MAX_DEVIATION,
    )
    return motion.trajectory(validity.joint_names)
