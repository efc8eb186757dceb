# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Single constraints, resolved for a scene: how far a state is from each.

The rules are those of MoveIt's ``kinematic_constraint.cpp``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.model.transforms import (
    euler_xyz,
    inverse_pose,
    matrix_from_axis_angle,
    rotation_vector,
)
from armsim_ros.planning.request import Region

EPSILON = 1e-9
"""What rounding may add [rad or m]."""

Poses = Mapping[str, Matrix]
"""Link -> pose (4, 4) in the model frame, of all links that constraints name."""


@dataclass(frozen=True, slots=True)
class ConstraintResult:
    """
    A constraint evaluated in a state.

    :param satisfied: whether the state satisfies the constraint.
    :param distance: distance from the constraint's centre [rad or m], times its weight.
    :param text: the constraint and the values, for messages.
    """

    satisfied: bool
    distance: float
    text: str


@dataclass(frozen=True, slots=True)
class FixedTerm:
    """A constraint with the same result in every state, as it cannot be evaluated."""

    result: ConstraintResult

    def residual(self) -> Vector:
        """Return nothing (0,) where it counts as satisfied, else an infinite distance (1,)."""
        return np.full(0 if self.result.satisfied else 1, math.inf)


@dataclass(frozen=True, slots=True)
class JointTerm:
    """
    An interval of a joint.

    :param index: place in the robot's state.
    :param target: [rad or m]; so are the others.
    :param below: tolerance below the target.
    :param above: tolerance above the target.
    :param lower: least value that satisfies the constraint within the joint's limits.
    :param upper: largest such value.
    """

    name: str
    index: int
    target: float
    below: float
    above: float
    lower: float
    upper: float
    continuous: bool
    weight: float

    @property
    def middle(self) -> float:
        """The target, or the joint's limit where the target is beyond it."""
        return min(max(self.target, self.lower), self.upper)

    def evaluate(self, q: Vector) -> ConstraintResult:
        """Return the result for a full robot state (n,)."""
        text = (f"joint '{self.name}' is at {q[self.index]:.4f}, wanted {self.target:.4f} in "
                f'{self.target - self.below:.4f} .. {self.target + self.above:.4f}')
        inside = abs(self.residual(q, 0.0)) <= EPSILON
        return ConstraintResult(inside, self.weight * abs(self.error(q)), text)

    def residual(self, q: Vector, margin: float) -> float:
        """Return by how much a state is beyond the interval, which a share makes smaller."""
        error, inside = self.error(q), 1.0 - margin
        return error - min(max(error, -inside * self.below), inside * self.above)

    def error(self, q: Vector) -> float:
        """Return position - target [rad or m], the short way round for a continuous joint."""
        error = float(q[self.index]) - self.target
        return math.remainder(error, 2.0 * math.pi) if self.continuous else error


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """A frame fixed to a link: pose of the frame = pose of the link * offset."""

    link: str
    offset: Matrix

    def pose(self, poses: Poses) -> Matrix:
        """Return the pose (4, 4) of the frame for poses of the links."""
        pose: Matrix = poses[self.link] @ self.offset
        return pose


@dataclass(frozen=True, slots=True, eq=False)
class PositionTerm:
    """
    A point that has to be in one of several regions.

    :param target: the point, as the origin of a frame.
    :param frame: the frame of the regions.
    """

    name: str
    target: Frame
    frame: Frame
    regions: tuple[Region, ...]
    weight: float

    @property
    def volume(self) -> float:
        """A measure of the volume of the regions."""
        return sum(region.size ** 3 for region in self.regions)

    def point(self, poses: Poses) -> Vector:
        """Return the point (3,) [m] in the constraint frame."""
        base = inverse_pose(self.frame.pose(poses))
        place: Vector = (base @ poses[self.target.link] @ self.target.offset)[:3, 3]
        return place

    def residual(self, poses: Poses, margin: float) -> Vector:
        """Return the way (3,) [m] to the point from the nearest region, made smaller."""
        point = self.point(poses)
        ways = [region.outside_by(point, margin) for region in self.regions]
        return min(ways, key=lambda way: float(np.linalg.norm(way)))

    def evaluate(self, poses: Poses) -> ConstraintResult:
        """
        Return the result for poses of the two links.

        The distance is that to the pose of the first region that holds the point, else of the
        last region.
        """
        point = self.point(poses)
        holding = (region for region in self.regions
                   if float(np.abs(region.outside_by(point)).max()) <= EPSILON)
        region = next(holding, None)
        measured = region or self.regions[-1]
        distance = float(np.linalg.norm(point - measured.pose[:3, 3]))
        text = (f"position of '{self.name}' is {distance:.5f} m from the centre of its region"
                + ('' if region else ' and outside'))
        return ConstraintResult(region is not None, self.weight * distance, text)


@dataclass(frozen=True, slots=True, eq=False)
class OrientationTerm:
    """
    A link's orientation relative to a desired orientation in a frame.

    XYZ Euler angles turn about the axes of the desired orientation, x first, each about the
    axis that the rotation before has turned. A rotation vector is given in the axes of the frame.

    :param desired: (3, 3) in the constraint frame.
    :param tolerances: (3,) [rad], infinite for a free axis.
    """

    name: str
    target: Frame
    frame: Frame
    desired: Matrix
    tolerances: Vector
    rotation_vector: bool
    weight: float

    @property
    def volume(self) -> float:
        """The volume [rad^3] that the tolerances leave."""
        return float(np.prod(np.minimum(self.tolerances, math.pi)))

    def error(self, poses: Poses) -> Vector:
        """Return the three angles (3,) [rad] from the desired orientation to the link's."""
        frame, link = self.frame.pose(poses)[:3, :3], self.target.pose(poses)[:3, :3]
        if self.rotation_vector:
            return rotation_vector(frame.T @ link @ self.desired.T)
        x, y, z = euler_xyz(self.desired.T @ frame.T @ link)
        if z == 0.0 and abs(x) > self.tolerances[2] and math.cos(y) < EPSILON:
            # Gimbal lock: only the sum of the two angles is known.
            return np.array([0.0, y, x])
        return np.array([x, y, z])

    def turned(self, angles: Vector) -> Matrix:
        """
        Return the orientation (3, 3) in the constraint frame that has a given error.

        :param angles: (3,) [rad].
        """
        if self.rotation_vector:
            angle = float(np.linalg.norm(angles))
            if angle < 1e-12:
                return self.desired
            return matrix_from_axis_angle(angles / angle, angle) @ self.desired
        turned = self.desired
        for axis, angle in zip(np.eye(3), angles, strict=True):
            turned = turned @ matrix_from_axis_angle(axis, float(angle))
        return turned

    def random(self, rng: np.random.Generator) -> Matrix:
        """Return a random orientation (3, 3) in the constraint frame within the tolerances."""
        reach = np.minimum(self.tolerances, math.pi)
        if not self.rotation_vector:
            reach[1] = min(reach[1], 0.5 * math.pi)
        return self.turned(rng.uniform(-reach, reach))

    def residual(self, poses: Poses, margin: float) -> Vector:
        """Return by how much each angle (3,) [rad] is beyond its tolerance, made smaller."""
        error, allowed = self.error(poses), (1.0 - margin) * self.tolerances
        beyond: Vector = error - np.clip(error, -allowed, allowed)
        return beyond

    def evaluate(self, poses: Poses) -> ConstraintResult:
        """Return the result for poses of the two links."""
        error = np.abs(self.error(poses))
        inside = bool(np.all(error <= self.tolerances + EPSILON))
        text = (f"orientation of '{self.name}' is off by {np.round(error, 4).tolist()} rad, "
                f'allowed {np.round(self.tolerances, 4).tolist()}')
        return ConstraintResult(inside, self.weight * float(error.sum()), text)
