# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Single constraints, resolved for a scene: how far a state is from each.

The rules are those of MoveIt's ``kinematic_constraint.cpp``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
import math
import sys
from typing import Any

import coal
import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.coal_shapes import exact_shape
from armsim_ros.model.transforms import (
    euler_xyz,
    inverse_pose,
    matrix_from_axis_angle,
    rotation_vector,
)
from armsim_ros.planning.request import Region, VisibilityConstraint

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

    def near(self, value: float) -> tuple[float, float]:
        """Return lower and upper; of a continuous joint those of the turn nearest to a value."""
        turn = 0.0
        if self.continuous:
            way = value - 0.5 * (self.lower + self.upper)
            turn = way - math.remainder(way, 2.0 * math.pi)
        return self.lower + turn, self.upper + turn

    def common(self, other: JointTerm) -> JointTerm:
        """Return this term with the values that another one for the joint allows, too."""
        lower, upper = other.near(0.5 * (self.lower + self.upper))
        lower, upper = max(self.lower, lower), min(self.upper, upper)
        if upper < lower <= upper + EPSILON:  # they meet in a value, but for rounding
            lower = upper = 0.5 * (lower + upper)
        return replace(self, lower=lower, upper=upper)

    def is_empty(self) -> bool:
        """Return whether there is no value between lower and upper."""
        return self.lower > self.upper


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


@dataclass(frozen=True, slots=True, eq=False)
class LinkShape:
    """
    A collision shape of a link.

    :param pose: (4, 4) on the link.
    :param shape: of coal.
    """

    link: str
    pose: Matrix
    shape: Any


def link_shapes(model: KinematicModel, exempt: Iterable[str]) -> tuple[LinkShape, ...]:
    """Return the collision shapes of all links but those that may be inside the cone."""
    return tuple(
        LinkShape(name, item.origin, exact_shape(item.geometry))
        for name, link in model.robot.links.items() if name not in exempt
        for item in link.collisions)


@dataclass(frozen=True, slots=True, eq=False)
class VisibilityTerm:
    """
    A disc that faces a sensor, in its field of view, with no link in between.

    :param given: radius, angles and number of sides.
    :param sensor: the frame whose axis is the direction of view.
    :param target: the frame of the disc, which lies in its x-y plane.
    :param shapes: those that must not touch the cone between the sensor and the disc.
    """

    given: VisibilityConstraint
    sensor: Frame
    target: Frame
    shapes: tuple[LinkShape, ...]

    @property
    def links(self) -> tuple[str, ...]:
        """All links whose poses are needed."""
        return self.sensor.link, self.target.link, *(each.link for each in self.shapes)

    def evaluate(self, poses: Poses) -> ConstraintResult:
        """Return the result for poses of the links; the distance is how deep a link reaches in."""
        given, sensor, target = self.given, self.sensor.pose(poses), self.target.pose(poses)
        axis: Vector = sensor[:3, 2 - given.sensor_view_direction]
        way = target[:3, 3] - sensor[:3, 3]
        length = float(np.linalg.norm(way))
        for name, direction, limit in (
            ('view', -target[:3, 2], given.max_view_angle),
            ('range', way / length if length > 0.0 else axis, given.max_range_angle),
        ):
            angle = math.acos(min(1.0, max(-1.0, float(axis @ direction))))
            if enabled(limit) and angle > min(limit, 0.5 * math.pi):
                return ConstraintResult(False, 0.0, (
                    f"the {name} angle from '{given.sensor_frame_id}' to "
                    f"'{given.target_frame_id}' is {angle:.4f} rad, above {limit:.4f}"))
        link, depth = self._deepest(sensor, target, poses)
        return ConstraintResult(not link, depth, (
            f"link '{link}' is between the sensor in '{given.sensor_frame_id}' and the target in "
            f"'{given.target_frame_id}'" if link else
            f"the target in '{given.target_frame_id}' is visible"))

    def _deepest(self, sensor: Matrix, target: Matrix, poses: Poses) -> tuple[str, float]:
        """Return the link that is deepest in the cone and how deep [m]; '' where none is."""
        if not enabled(abs(self.given.target_radius)):
            return '', 0.0
        cone = self._cone(sensor, target)
        request = coal.CollisionRequest()
        link, deepest = '', 0.0
        for each in self.shapes:
            pose = poses[each.link] @ each.pose
            result = coal.CollisionResult()
            coal.collide(cone, coal.Transform3s.Identity(), each.shape,
                         coal.Transform3s(pose[:3, :3], pose[:3, 3]), request, result)
            if result.isCollision():
                depth = abs(float(result.getContact(0).penetration_depth))
                if not link or depth > deepest:
                    link, deepest = each.link, depth
        return link, deepest

    def _cone(self, sensor: Matrix, target: Matrix) -> Any:
        """Return the solid between the sensor and the disc as coal's shape."""
        sides = max(3, self.given.cone_sides)
        angles = 2.0 * math.pi / sides * np.arange(sides)
        rim = self.given.target_radius * np.array([np.sin(angles), np.cos(angles), 0.0 * angles])
        corners = coal.StdVec_Vec3s()
        corners.extend([sensor[:3, 3], target[:3, 3], *(target[:3, :3] @ rim).T + target[:3, 3]])
        return coal.Convex(corners, _triangles(sides))


@lru_cache(8)
def _triangles(sides: int) -> Any:
    """Return the triangles of a cone whose corners are its tip, the disc's middle and its rim."""
    triangles = coal.StdVec_Triangle()
    for side in range(sides):
        for middle in (0, 1):
            triangles.append(coal.Triangle(2 + side, middle, 2 + (side + 1) % sides))
    return triangles


def enabled(value: float) -> bool:
    """Return whether a radius [m] or an angle [rad] is a condition."""
    return value > sys.float_info.epsilon
