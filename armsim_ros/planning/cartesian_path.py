# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Paths on which a link moves straight from waypoint to waypoint."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
import math

import numpy as np
from numpy.typing import NDArray

from armsim_ros.kinematics.inverse import IKTarget, InverseKinematics
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.robot_model import JointType
from armsim_ros.model.transforms import matrix_from_axis_angle, rotation_angle
from armsim_ros.planning.constraint_terms import Frame, rotation_vector
from armsim_ros.planning.request import Constraints, StartState
from armsim_ros.planning.state_validity import StateValidity

Vector = NDArray[np.float64]

ROTATION_PER_STEP = 3.5
"""Turn [rad] that counts as much as one metre of ``max_step``."""

_POSITION_PRECISION = 1e-3
_ROTATION_PRECISION = 1e-2
_MIN_PART = 1e-5
_NO_TURN = 1e-9
_FARTHEST = 1.5


@dataclass(frozen=True, slots=True, eq=False)
class CartesianRequest:
    """
    A path through poses of a link.

    :param waypoints: (4, 4) each in ``frame_id``; where that is the link itself, each is
        relative to the link's pose at the end of the segment before.
    :param link_name: '' for the group's last link.
    :param max_step: [m] between two states of the path.
    :param jump_threshold: largest joint step, as a multiple of the mean; 0 is no limit.
    :param prismatic_jump_threshold: largest step of a prismatic joint [m]; 0 is no limit.
    :param revolute_jump_threshold: largest step of a revolute joint [rad]; 0 is no limit.
    """

    group_name: str
    waypoints: tuple[Vector, ...]
    max_step: float
    link_name: str = ''
    frame_id: str = ''
    start_state: StartState = field(default_factory=StartState)
    jump_threshold: float = 0.0
    prismatic_jump_threshold: float = 0.0
    revolute_jump_threshold: float = 0.0
    avoid_collisions: bool = True
    path_constraints: Constraints = field(default_factory=Constraints)
    max_velocity_scaling_factor: float = 1.0
    max_acceleration_scaling_factor: float = 1.0
    cartesian_speed_limited_link: str = ''
    max_cartesian_speed: float = 0.0


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

    :param model: the robot's kinematics.
    :param inverse: of the group; it starts from the state before and nowhere else.
    :param validity: judges every state and the motions between them.
    :param frame: what is moved, a frame fixed to a link of the group.
    :param position_only: leave the orientation free.
    """

    def __init__(
        self, model: KinematicModel, inverse: InverseKinematics, validity: StateValidity,
        frame: Frame, *, position_only: bool = False,
    ) -> None:
        """Keep the parts."""
        self._model = model
        self._inverse = inverse
        self._validity = validity
        self._frame = frame
        self._position_only = position_only

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
        here = self._pose(start)
        for number, waypoint in enumerate(waypoints):
            target = here @ waypoint if relative else waypoint
            segment = _Segment(here, target)
            turn = 0.0 if self._position_only else segment.angle
            distance = float(np.linalg.norm(target[:3, 3] - here[:3, 3]))
            parts = math.floor(
                max(distance / max_step, turn / (ROTATION_PER_STEP * max_step))
            ) + 1
            for part in range(parts):
                self._validity.poll()
                self._advance(path, segment, number, part / parts, (part + 1) / parts, step)
                if path.reason:
                    return path
            here = target
        return path

    def _pose(self, values: Vector) -> Vector:
        link = self._model.link_pose(self._validity.full(values), self._frame.link)
        pose: Vector = link @ self._frame.offset
        return pose

    def _advance(
        self, path: CartesianPath, segment: _Segment, number: int, low: float, high: float,
        step: float,
    ) -> None:
        """Add the state at part ``high`` of a segment, and others before it where needed."""
        last = path.states[-1]
        target = IKTarget(
            self._frame.link, segment.pose(high), self._frame.offset, self._position_only)
        for start in path.starts(number + high):
            result = self._inverse.solve([target], self._validity.full(start), max_starts=0)
            if result.q is not None:
                break
        where = f'waypoint {number + 1}, {high:.0%} of its segment'
        if result.q is None:
            if high - low > _MIN_PART * 64.0:
                self._halves(path, segment, number, low, high, step)
            else:
                path.reason = f'{where}: {result.message}'
            return
        values = self._model.extract(result.q, self._validity.group)
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
        self, path: CartesianPath, segment: _Segment, number: int, low: float, high: float,
        step: float,
    ) -> None:
        middle = 0.5 * (low + high)
        self._advance(path, segment, number, low, middle, step)
        if not path.reason:
            self._advance(path, segment, number, middle, high, step)

    def _straight(self, first: Vector, second: Vector, wanted: Vector) -> bool:
        """Return whether the joint motion's middle lies on the Cartesian path."""
        pose = self._pose(0.5 * (first + second))
        off = pose[:3, 3] - wanted[:3, 3]
        if math.sqrt(float(off @ off)) > _POSITION_PRECISION:
            return False
        return self._position_only or rotation_angle(pose, wanted) <= _ROTATION_PRECISION


class _Segment:
    """The poses (4, 4) from one to another, position and rotation at even speed."""

    def __init__(self, first: Vector, last: Vector) -> None:
        self._first = first
        self._way = last[:3, 3] - first[:3, 3]
        self.angle = rotation_angle(first, last)
        self._axis = np.zeros(3)
        if self.angle > _NO_TURN:
            turn = rotation_vector(first[:3, :3].T @ last[:3, :3])
            self._axis = turn / np.linalg.norm(turn)

    def pose(self, part: float) -> Vector:
        """Return the pose a part 0..1 of the way."""
        pose = self._first.copy()
        pose[:3, 3] += part * self._way
        if self.angle > _NO_TURN:
            pose[:3, :3] = pose[:3, :3] @ matrix_from_axis_angle(self._axis, part * self.angle)
        return pose


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
