# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Lines and arcs between poses, and how an arm follows them."""

from __future__ import annotations

from abc import ABC, abstractmethod
import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.kinematics.inverse import IKOptions, IKResult, IKTarget
from armsim_ros.model.transforms import (
    matrix_from_axis_angle,
    pose_from_parts,
    rotation_angle,
    rotation_vector,
)
from armsim_ros.planning.collision.state_validity import StateValidity
from armsim_ros.planning.constraint_terms import Frame
from armsim_ros.planning.context import PlanningContext

_SOURCE = 'CIRC'
_LEAST_RADIUS = 1e-5  # [m]
_COLINEAR = 1e-5  # sine at a centre; [m^2] of start, interim point and goal
_RADIUS_TOLERANCE = 1e-2  # [m]


class Curve(ABC):
    """
    A path of poses over a place 0..1, at even speed; the orientation turns evenly.

    :param first: (4, 4).
    :param last: (4, 4).
    """

    #: Length of the path of the point [m].
    length: float

    def __init__(self, first: Matrix, last: Matrix) -> None:
        self._rotation = first[:3, :3]
        turn = rotation_vector(self._rotation.T @ last[:3, :3])
        #: Turn from the first orientation to the last [rad].
        self.angle = float(np.linalg.norm(turn))
        self._velocity: Vector = self._rotation @ turn

    def pose(self, place: float) -> Matrix:
        """Return the pose (4, 4) at a place."""
        rotation = self._rotation
        if self.angle >= 1e-12:
            axis = self._velocity / self.angle
            rotation = matrix_from_axis_angle(axis, place * self.angle) @ rotation
        return pose_from_parts(self._point(place), rotation)

    @abstractmethod
    def _point(self, place: float) -> Vector:
        """Return the position (3,) [m] at a place."""


class Line(Curve):
    """A straight line between two poses (4, 4)."""

    def __init__(self, first: Matrix, last: Matrix) -> None:
        super().__init__(first, last)
        self._origin = first[:3, 3]
        self._way: Vector = last[:3, 3] - first[:3, 3]
        self.length = float(np.linalg.norm(self._way))

    def _point(self, place: float) -> Vector:
        return self._origin + place * self._way


class Arc(Curve):
    """
    An arc of a circle between two poses (4, 4).

    :param center: (3,) of the circle.
    :param normal: (3,) axis about which the point turns to the right-hand side.
    :param sweep: [rad] above 0.
    """

    def __init__(
        self, first: Matrix, last: Matrix, center: Vector, normal: Vector, sweep: float
    ) -> None:
        super().__init__(first, last)
        self._center = center
        self._x: Vector = first[:3, 3] - center
        self._y: Vector = np.cross(normal, self._x)
        self._sweep = sweep
        self.length = float(np.linalg.norm(self._x)) * sweep

    def _point(self, place: float) -> Vector:
        angle = place * self._sweep
        point: Vector = self._center + math.cos(angle) * self._x + math.sin(angle) * self._y
        return point

    @classmethod
    def around(cls, first: Vector, last: Vector, center: Vector) -> Arc:
        """
        Return the shorter arc about a centre.

        :raises PlanningError: INVALID_MOTION_PLAN where both ends are not equally far from it,
            or on a line with it.
        """
        a, b = first[:3, 3] - center, last[:3, 3] - center
        radius, other = float(np.linalg.norm(a)), float(np.linalg.norm(b))
        if min(radius, other) < _LEAST_RADIUS:
            raise _error('the centre of the circle is where the motion starts or ends: its radius '
                         'would be 0')
        if abs(radius - other) > _RADIUS_TOLERANCE:
            raise _error(f'start and goal are {radius:.4f} m and {other:.4f} m from the centre; '
                         'both have to be equally far from it')
        normal = np.cross(a, b)
        size = float(np.linalg.norm(normal))
        if size < _COLINEAR * radius * other:
            raise _error('start, centre and goal are collinear: the plane of the circle is not '
                         "determined; give a point of the arc with the name 'interim'")
        sweep = math.atan2(size, float(a @ b))
        return cls(first, last, center, normal / size, sweep)

    @classmethod
    def through(cls, first: Vector, last: Vector, interim: Vector) -> Arc:
        """
        Return the arc through a third point.

        :raises PlanningError: INVALID_MOTION_PLAN where the three lie on a line.
        """
        a, b = interim - first[:3, 3], last[:3, 3] - first[:3, 3]
        normal = np.cross(a, b)
        size = float(np.linalg.norm(normal))
        if size < _COLINEAR:
            raise _error('start, interim point and goal are collinear: no circle goes through '
                         'them')
        to_center = (
            float(b @ b) * np.cross(normal, a) + float(a @ a) * np.cross(b, normal)
        ) / (2.0 * size**2)
        center = first[:3, 3] + to_center
        axis = normal / size
        start, end = first[:3, 3] - center, last[:3, 3] - center
        sweep = math.atan2(float(axis @ np.cross(start, end)), float(start @ end)) % (
            2.0 * math.pi)
        return cls(first, last, center, axis, sweep)


def _error(text: str) -> PlanningError:
    return PlanningError(MoveItErrorCode.INVALID_MOTION_PLAN, text, _SOURCE)


class CurveFollower:
    """
    Inverse kinematics that stays in the basin of the state before.

    :param context: the robot and its solvers.
    :param validity: of the group that moves.
    :param frame: what follows the curve, a frame fixed to a link of the group.
    """

    def __init__(
        self, context: PlanningContext, validity: StateValidity, frame: Frame
    ) -> None:
        self.frame = frame
        #: Whether orientations are left free.
        self.position_only = validity.group in context.settings.position_only_ik
        self._validity = validity
        self._model = context.model
        self._inverse = context.inverse(validity.group)

    def pose(self, values: Vector) -> Matrix:
        """Return where the frame is, (4, 4), for the group's values (m,)."""
        link = self._model.link_pose(self._validity.full(values), self.frame.link)
        pose: Matrix = link @ self.frame.offset
        return pose

    def solve(self, pose: Matrix, start: Vector) -> tuple[Vector | None, IKResult]:
        """
        Return the state (m,) with the frame at a pose (4, 4), None where there is none nearby.

        :param start: (m,) state to start from.
        """
        target = IKTarget(self.frame.link, pose, self.frame.offset, self.position_only)
        result = self._inverse.solve(
            [target], self._validity.full(start), IKOptions(max_starts=0))
        found = result.q
        if found is not None:
            found = self._model.extract(found, self._validity.group)
        return found, result

    def distance(self, values: Vector, pose: Matrix) -> tuple[float, float]:
        """Return how far the frame is from a pose (4, 4): [m] and [rad], 0 where it is free."""
        here = self.pose(values)
        turn = 0.0 if self.position_only else rotation_angle(here, pose)
        return float(np.linalg.norm(here[:3, 3] - pose[:3, 3])), turn
