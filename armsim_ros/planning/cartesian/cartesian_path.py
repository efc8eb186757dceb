# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Paths on which a link moves straight between waypoints: followed, cut at jumps, timed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
import math

import numpy as np

from armsim_ros.arrays import Vector
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
from armsim_ros.planning.timing.quintic import QuinticMotion
from armsim_ros.trajectory import JointTrajectory

ROTATION_PER_STEP = 3.5
"""Turn [rad] that counts as much as one metre of ``max_step``."""

MOST_STATES = 5000
"""A request whose ``max_step`` asks for more states gets a larger step."""

_POSITION_PRECISION = 1e-3
_ROTATION_PRECISION = 1e-2
_MIN_PART = 1e-5
_FARTHEST = 1.5


@dataclass(slots=True, eq=False)
class CartesianPath:
    """
    Joint states along a Cartesian path, as far as it goes.

    :param states: (m,) of the group; the first is the start.
    :param places: how much of the path each state has covered, in waypoints.
    :param total: number of waypoints.
    :param reason: why it ends early, '' where it does not.
    """

    states: list[Vector]
    places: list[float]
    total: int
    reason: str = ''

    @property
    def fraction(self) -> float:
        """Covered part of the path, 0..1."""
        return min(1.0, self.places[-1] / self.total) if self.total else 0.0

    def starts(self, place: float) -> list[Vector]:
        """Return where the state at the next place may be near: straight on, or the last one."""
        last = self.states[-1]
        if len(self.states) < 2:
            return [last]
        rate = (place - self.places[-1]) / max(self.places[-1] - self.places[-2], _MIN_PART)
        if rate > _FARTHEST:
            return [last]
        return [last + rate * (last - self.states[-2]), last]

    def cut(self, count: int, reason: str) -> None:
        """Keep the first states only."""
        del self.states[count:]
        del self.places[count:]
        self.reason = reason


class CartesianInterpolator:
    """
    Follows straight lines and even rotations with inverse kinematics.

    :param follower: takes the frame from pose to pose.
    :param validity: judges every state and the motions between them.
    """

    def __init__(self, follower: CurveFollower, validity: StateValidity) -> None:
        self._follower = follower
        self._validity = validity

    def follow(
        self, start: Vector, waypoints: tuple[Vector, ...], max_step: float, step: float, *,
        relative: bool = False,
    ) -> CartesianPath:
        """
        Return the path from a start (m,) through poses (4, 4) in the model frame.

        :param step: largest motion [m] of any point between two checks.
        :param relative: each pose is relative to the pose before it.
        """
        path = CartesianPath([start], [0.0], len(waypoints))
        wrong = '' if self._validity.free(start) else self._validity.why_not(start)
        if wrong:
            path.reason = f'the start state is not valid: {wrong}'
            return path
        here = self._follower.pose(start)
        for number, waypoint in enumerate(waypoints):
            target = here @ waypoint if relative else waypoint
            segment = Line(here, target)
            turn = 0.0 if self._follower.position_only else segment.angle
            parts = math.floor(
                max(segment.length / max_step, turn / (ROTATION_PER_STEP * max_step))
            ) + 1
            for part in range(parts):
                self._validity.poll()
                self._advance(path, segment, number, part / parts, (part + 1) / parts, step)
                if path.reason:
                    return path
            here = target
        return path

    def _advance(
        self, path: CartesianPath, segment: Line, number: int, low: float, high: float,
        step: float,
    ) -> None:
        """Add the state at part ``high`` of a segment, and others before it where needed."""
        last = path.states[-1]
        values, result = self._follower.solve(
            segment.pose(high), *path.starts(number + high))
        where = f'waypoint {number + 1}, {high:.0%} of its segment'
        if values is None:
            if high - low > _MIN_PART * 64.0:
                self._halves(path, segment, number, low, high, step)
            else:
                path.reason = f'{where}: {result.message}'
            return
        if not self._straight(last, values, segment.pose(0.5 * (low + high))):
            if high - low > _MIN_PART:
                self._halves(path, segment, number, low, high, step)
            else:
                path.reason = f'{where}: the joints would have to jump'
            return
        if not self._validity.motion_free(last, values, step):
            path.reason = f'{where}: {self._validity.why_not(values) or "something is in between"}'
            return
        path.states.append(values)
        path.places.append(number + high)

    def _halves(
        self, path: CartesianPath, segment: Line, number: int, low: float, high: float,
        step: float,
    ) -> None:
        middle = 0.5 * (low + high)
        self._advance(path, segment, number, low, middle, step)
        if not path.reason:
            self._advance(path, segment, number, middle, high, step)

    def _straight(self, first: Vector, second: Vector, wanted: Vector) -> bool:
        """Return whether the joint motion's middle lies on the Cartesian path."""
        off, turned = self._follower.distance(0.5 * (first + second), wanted)
        return off <= _POSITION_PRECISION and turned <= _ROTATION_PRECISION


def cut_at_jump(
    path: CartesianPath, request: CartesianRequest, joint_types: tuple[JointType, ...]
) -> None:
    """
    End a path before the first joint step that is larger than the request allows.

    The relative threshold compares joint motion per distance covered with its mean.

    :param joint_types: of the group's variables.
    """
    if len(path.states) < 2:
        return
    steps = np.array([b - a for a, b in pairwise(path.states)])
    covered = np.maximum(np.diff(path.places), 1e-12)
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
        path.cut(first + 1, f'a joint would jump by {largest:.4f}, more than the threshold')


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
    if not relative:
        base = scene.frame_pose(request.frame_id, scene.q)
        waypoints = tuple(base @ waypoint for waypoint in waypoints)
    if relative:
        moves = [Line(np.eye(4), waypoint) for waypoint in waypoints]
    else:
        here = scene.frame_pose(frame.link) @ frame.offset
        moves = [Line(first, last) for first, last in pairwise((here, *waypoints))]
    interpolator = CartesianInterpolator(CurveFollower(context, validity, frame), validity)
    path = interpolator.follow(
        context.model.extract(scene.q, group), waypoints,
        _step(context, request.max_step, moves), context.settings.fine_step, relative=relative,
    )
    joints = context.model.robot.joints
    cut_at_jump(path, request, tuple(joints[name].type for name in validity.joint_names))
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
