# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Single constraints on a joint, a point or an orientation, and their errors."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.model.transforms import inverse_pose, rotation_vector
from armsim_ros.planning.constraints.regions import contains, outside_by, region_center
from armsim_ros.planning.request import Region

EPSILON = 1e-9
"""What rounding may add [rad or m]."""


@dataclass(frozen=True, slots=True)
class ConstraintResult:
    """
    How a state stands to one constraint.

    :param satisfied: whether it is kept.
    :param distance: how far from the constraint's centre [rad or m], times its weight.
    :param text: the constraint and the values, for messages.
    """

    satisfied: bool
    distance: float
    text: str


@dataclass(frozen=True, slots=True)
class JointTerm:
    """An interval of one joint; ``index`` counts in the robot's state."""

    name: str
    index: int
    target: float
    lower: float
    upper: float
    continuous: bool
    weight: float

    def evaluate(self, q: Vector) -> ConstraintResult:
        """Return how a state stands to this constraint."""
        error = self.error(q)
        low, high = self.lower - self.target, self.upper - self.target
        inside = low - EPSILON <= error <= high + EPSILON
        text = (
            f"joint '{self.name}' is at {q[self.index]:.4f}, wanted {self.target:.4f} in "
            f'{self.lower:.4f} .. {self.upper:.4f}'
        )
        return ConstraintResult(inside, self.weight * abs(error), text)

    def residual(self, q: Vector, margin: float) -> float:
        """Return by how much a state lies beyond the interval, made smaller by a share."""
        error = self.error(q)
        low, high = (1.0 - margin) * (self.lower - self.target), (1.0 - margin) * (
            self.upper - self.target)
        return error - min(max(error, low), high)

    def error(self, q: Vector) -> float:
        """Return position - target [rad or m], the short way round for a continuous joint."""
        error = float(q[self.index]) - self.target
        return math.remainder(error, 2.0 * math.pi) if self.continuous else error


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """A frame fixed to a link: pose of the frame = pose of the link * offset."""

    link: str
    offset: Vector


@dataclass(frozen=True, slots=True, eq=False)
class PositionTerm:
    """
    A point that has to lie in one of several regions.

    :param target: the point, as the origin of a frame.
    :param frame: the frame of the regions.
    """

    name: str
    target: Frame
    frame: Frame
    regions: tuple[Region, ...]
    weight: float

    def point(self, link_pose: Vector, frame_pose: Vector) -> Vector:
        """Return the point (3,) [m] in the constraint frame."""
        place: Vector = (
            inverse_pose(frame_pose @ self.frame.offset) @ link_pose @ self.target.offset
        )[:3, 3]
        return place

    def residual(self, link_pose: Vector, frame_pose: Vector, margin: float) -> Vector:
        """Return the way (3,) [m] to the point from the nearest region, made smaller."""
        point = self.point(link_pose, frame_pose)
        ways = [outside_by(region, point, margin) for region in self.regions]
        return min(ways, key=lambda way: float(np.linalg.norm(way)))

    def evaluate(self, link_pose: Vector, frame_pose: Vector) -> ConstraintResult:
        """Return how poses of the two links stand to this constraint."""
        point = self.point(link_pose, frame_pose)
        inside = any(contains(region, point) for region in self.regions)
        distance = min(
            float(np.linalg.norm(point - region_center(region))) for region in self.regions
        )
        text = (f"position of '{self.name}' is {distance:.5f} m from the centre of its region"
                + ('' if inside else ' and outside'))
        return ConstraintResult(inside, self.weight * distance, text)


@dataclass(frozen=True, slots=True, eq=False)
class OrientationTerm:
    """
    A link's orientation in a frame.

    :param wanted: (3, 3) in the constraint frame.
    :param tolerances: (3,) [rad] about the constraint frame's axes.
    """

    name: str
    target: Frame
    frame: Frame
    wanted: Vector
    tolerances: Vector
    rotation_vector: bool
    weight: float

    def error(self, link_pose: Vector, frame_pose: Vector) -> Vector:
        """Return the three angles of the error (3,) [rad]."""
        frame = (frame_pose @ self.frame.offset)[:3, :3]
        link = (link_pose @ self.target.offset)[:3, :3]
        difference = frame.T @ link @ self.wanted.T
        return rotation_vector(difference) if self.rotation_vector else euler_xyz(difference)

    def residual(self, link_pose: Vector, frame_pose: Vector, margin: float) -> Vector:
        """Return by how much each angle (3,) [rad] is beyond its tolerance, made smaller."""
        error = self.error(link_pose, frame_pose)
        allowed = (1.0 - margin) * self.tolerances
        beyond: Vector = error - np.clip(error, -allowed, allowed)
        return beyond

    def evaluate(self, link_pose: Vector, frame_pose: Vector) -> ConstraintResult:
        """Return how poses of the two links stand to this constraint."""
        error = self.error(link_pose, frame_pose)
        inside = bool(np.all(np.abs(error) <= self.tolerances + 1e-9))
        text = (f"orientation of '{self.name}' is off by {np.round(error, 4).tolist()} rad, "
                f'allowed {np.round(self.tolerances, 4).tolist()}')
        return ConstraintResult(inside, self.weight * float(np.linalg.norm(error)), text)


def euler_xyz(rotation: Vector) -> Vector:
    """Return the angles (3,) [rad] of the rotations about x, then the new y, then the new z."""
    y = math.atan2(rotation[0, 2], math.hypot(rotation[0, 0], rotation[0, 1]))
    if math.hypot(rotation[0, 0], rotation[0, 1]) < 1e-9:
        return np.array([math.atan2(rotation[1, 0], rotation[1, 1]), y, 0.0])
    return np.array([
        math.atan2(-rotation[1, 2], rotation[2, 2]), y,
        math.atan2(-rotation[0, 1], rotation[0, 0]),
    ])
