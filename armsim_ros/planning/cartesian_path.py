# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Paths on which a link moves straight from waypoint to waypoint."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
import math

import numpy as np
from numpy.typing import NDArray

from armsim_ros.kinematics.inverse import IKTarget, InverseKinematics
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.robot_model import JointType
from armsim_ros.model.transforms import (
    matrix_from_axis_angle,
    pose_from_parts,
    rotation_angle,
)
from armsim_ros.planning.constraint_terms import Frame, rotation_vector
from armsim_ros.planning.request import Constraints, StartState
from armsim_ros.planning.state_validity import StateValidity

Vector = NDArray[np.float64]

ROTATION_PER_STEP = 3.5
"""Turn [rad] that counts as much as one metre of ``max_step``."""

_POSITION_PRECISION = 1e-3
_ROTATION_PRECISION = 1e-2
_MIN_PART = 1e-5


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
        relative: bool = False, cancelled: Callable[[], bool],
    ) -> CartesianPath:
        """
        Return the path from a start (m,) through poses (4, 4) in the model frame.

        :param step: largest motion [m] of any point between two checks.
        :param relative: each pose is relative to the pose before it.
        :param cancelled: polled once a state; True ends the path.
        """
        path = CartesianPath([start], [0.0], len(waypoints))
        wrong = '' if self._validity.free(start) else self._validity.why_not(start)
        if wrong:
            path.reason = f'the start state is not valid: {wrong}'
            return path
        here = self._pose(start)
        for number, waypoint in enumerate(waypoints):
            target = here @ waypoint if relative else waypoint
            turn = 0.0 if self._position_only else rotation_angle(here, target)
            distance = float(np.linalg.norm(target[:3, 3] - here[:3, 3]))
            parts = math.floor(
                max(distance / max_step, turn / (ROTATION_PER_STEP * max_step))
            ) + 1
            for part in range(parts):
                if cancelled():
                    path.reason = 'the request was cancelled'
                    return path
                self._advance(
                    path, here, target, number, part / parts, (part + 1) / parts, step
                )
                if path.reason:
                    return path
            here = target
        return path

    def _pose(self, values: Vector) -> Vector:
        link = self._model.link_pose(self._validity.full(values), self._frame.link)
        pose: Vector = link @ self._frame.offset
        return pose

    def _advance(
        self, path: CartesianPath, a: Vector, b: Vector, number: int, low: float, high: float,
        step: float,
    ) -> None:
        """Add the state at part ``high`` of a segment, and others before it where needed."""
        last = path.states[-1]
        result = self._inverse.solve(
            [IKTarget(self._frame.link, _between(a, b, high), self._frame.offset,
                      self._position_only)],
            self._validity.full(last), max_starts=0,
        )
        where = f'waypoint {number + 1}, {high:.0%} of its segment'
        if result.q is None:
            if high - low > _MIN_PART * 64.0:
                self._halves(path, a, b, number, low, high, step)
            else:
                path.reason = f'{where}: {result.message}'
            return
        values = self._model.extract(result.q, self._validity.group)
        if not self._straight(last, values, a, b, 0.5 * (low + high)):
            if high - low > _MIN_PART:
                self._halves(path, a, b, number, low, high, step)
            else:
                path.reason = f'{where}: the joints would have to jump'
            return
        if not self._validity.motion_free(last, values, step):
            path.reason = f'{where}: {self._validity.why_not(values) or "something is in between"}'
            return
        path.states.append(values)
        path.places.append(number + high)

    def _halves(
        self, path: CartesianPath, a: Vector, b: Vector, number: int, low: float, high: float,
        step: float,
    ) -> None:
        middle = 0.5 * (low + high)
        self._advance(path, a, b, number, low, middle, step)
        if not path.reason:
            self._advance(path, a, b, number, middle, high, step)

    def _straight(
        self, first: Vector, second: Vector, a: Vector, b: Vector, part: float
    ) -> bool:
        """Return whether the joint motion's middle lies on the Cartesian path."""
        pose = self._pose(0.5 * (first + second))
        wanted = _between(a, b, part)
        off = float(np.linalg.norm(pose[:3, 3] - wanted[:3, 3]))
        if off > _POSITION_PRECISION:
            return False
        return self._position_only or rotation_angle(pose, wanted) <= _ROTATION_PRECISION


def _between(a: Vector, b: Vector, part: float) -> Vector:
    """Return the pose (4, 4) a part 0..1 of the way, position and rotation at even speed."""
    turn = rotation_vector(a[:3, :3].T @ b[:3, :3])
    angle = float(np.linalg.norm(turn))
    rotation = a[:3, :3]
    if angle > 1e-12:
        rotation = rotation @ matrix_from_axis_angle(turn / angle, part * angle)
    return pose_from_parts(a[:3, 3] + part * (b[:3, 3] - a[:3, 3]), rotation)


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
