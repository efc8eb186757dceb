# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Constraints on states, resolved: joint intervals, regions of points, orientations."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.model.geometry import (
    Box,
    Capsule,
    Cone,
    Cylinder,
    Geometry,
    half_extent,
    Mesh,
    Plane,
    shape_fault,
    Sphere,
)
from armsim_ros.model.transforms import inverse_pose, rotation_vector
from armsim_ros.planning.request import Region

_EPSILON = 1e-9


FARTHEST = 1e6
"""Numbers beyond this [m] are no places."""


def is_place(values: Vector) -> bool:
    """Return whether all numbers of a pose or point are finite and not out of this world."""
    return bool(np.all(np.isfinite(values)) and np.all(np.abs(values) <= FARTHEST))


def region_fault(region: Region) -> str:
    """Return what is wrong with a region, as a phrase, or ''."""
    if not is_place(region.pose):
        return 'its pose has a number that is not finite or too large'
    return shape_fault(region.shape)


def contains(region: Region, point: Vector) -> bool:
    """
    Return whether a point lies in a region, its border included.

    :param point: (3,) [m] in the frame that the region's pose is given in.
    """
    local = (inverse_pose(region.pose) @ np.append(point, 1.0))[:3]
    return _inside(region.shape, local)


def outside_by(region: Region, point: Vector, margin: float = 0.0) -> Vector:
    """
    Return the way (3,) [m] from a region to a point that lies outside, zeros inside.

    :param point: (3,) [m] in the frame that the region's pose is given in.
    :param margin: share 0..1 by which the region is smaller than given.
    """
    local = (inverse_pose(region.pose) @ np.append(point, 1.0))[:3]
    way: Vector = region.pose[:3, :3] @ (local - _nearest_inside(region.shape, local, margin))
    return way


def _nearest_inside(shape: Geometry, point: Vector, margin: float) -> Vector:
    """Return the nearest point (3,) of a box, ball or cylinder; of others, its middle."""
    inside = 1.0 - margin
    if isinstance(shape, Box):
        half = 0.5 * inside * np.asarray(shape.size)
        return np.clip(point, -half, half)
    if isinstance(shape, Sphere):
        distance = float(np.linalg.norm(point))
        return point * min(1.0, inside * shape.radius / max(distance, 1e-12))
    if isinstance(shape, Cylinder):
        around = float(np.hypot(point[0], point[1]))
        factor = min(1.0, inside * shape.radius / max(around, 1e-12))
        top = 0.5 * inside * shape.length
        return np.array([point[0] * factor, point[1] * factor,
                         float(np.clip(point[2], -top, top))])
    return point if _inside(shape, point) else _middle(shape)


def _inside(shape: Geometry, point: Vector) -> bool:
    x, y, z = (float(part) for part in point)
    radius = math.hypot(x, y)
    if isinstance(shape, Box):
        half = 0.5 * np.asarray(shape.size) + _EPSILON
        return bool(np.all(np.abs(point) <= half))
    if isinstance(shape, Sphere):
        return float(np.linalg.norm(point)) <= shape.radius + _EPSILON
    if isinstance(shape, Cylinder):
        return radius <= shape.radius + _EPSILON and abs(z) <= 0.5 * shape.length + _EPSILON
    if isinstance(shape, Cone):
        here = shape.radius * (0.5 - z / shape.length)
        return radius <= here + _EPSILON and abs(z) <= 0.5 * shape.length + _EPSILON
    if isinstance(shape, Capsule):
        beyond = max(abs(z) - 0.5 * shape.length, 0.0)
        return math.hypot(radius, beyond) <= shape.radius + _EPSILON
    if isinstance(shape, Plane):
        return shape.a * x + shape.b * y + shape.c * z + shape.d <= _EPSILON
    return _winding_number(shape, point) > 0.5


def _winding_number(mesh: Mesh, point: Vector) -> float:
    """
    Return how often a closed mesh goes round a point, 0 outside.

    The sum of the triangles' solid angles (van Oosterom and Strackee 1983).
    """
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] - point for k in range(3))
    la, lb, lc = (np.linalg.norm(each, axis=1) for each in (a, b, c))
    volume = np.einsum('ij,ij->i', a, np.cross(b, c))
    rest = (
        la * lb * lc
        + np.einsum('ij,ij->i', a, b) * lc
        + np.einsum('ij,ij->i', b, c) * la
        + np.einsum('ij,ij->i', c, a) * lb
    )
    return abs(float(np.sum(np.arctan2(volume, rest)))) / (2.0 * math.pi)


def region_center(region: Region) -> Vector:
    """Return the middle (3,) [m] of a region in the frame of its pose."""
    middle: Vector = (region.pose @ np.append(_middle(region.shape), 1.0))[:3]
    return middle


def _middle(shape: Geometry) -> Vector:
    if isinstance(shape, Mesh):
        result: Vector = 0.5 * (shape.vertices.min(axis=0) + shape.vertices.max(axis=0))
        return result
    return np.zeros(3)


def region_size(region: Region) -> float:
    """Return about how far [m] a point of the region may be from its middle."""
    return float(np.linalg.norm(_half_extent(region.shape)))


def _half_extent(shape: Geometry) -> Vector:
    if isinstance(shape, Plane):
        return np.full(3, 1.0)
    if isinstance(shape, Mesh):
        half: Vector = 0.5 * (shape.vertices.max(axis=0) - shape.vertices.min(axis=0))
        return half
    return half_extent(shape)


def random_point(region: Region, rng: np.random.Generator) -> Vector:
    """
    Return a random point (3,) [m] of a region in the frame of its pose.

    Drawn evenly from the shape's box until one is inside, at most 100 times; then the middle.
    """
    middle, half = _middle(region.shape), _half_extent(region.shape)
    for _ in range(100):
        point = middle + rng.uniform(-half, half)
        if _inside(region.shape, point):
            found: Vector = (region.pose @ np.append(point, 1.0))[:3]
            return found
    return region_center(region)


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
