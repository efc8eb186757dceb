# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Points in shapes: which are inside, and random ones."""

from __future__ import annotations

import math

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.model.geometry import Box, Capsule, Cone, Cylinder, Geometry, Mesh, Plane, Sphere
from armsim_ros.model.transforms import inverse_pose
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
    shape = region.shape
    if isinstance(shape, Mesh):
        if not len(shape.vertices) or not len(shape.triangles) or not is_place(shape.vertices):
            return 'its mesh has no triangles, or a number that is not finite'
        return ''
    if isinstance(shape, Box):
        sizes: tuple[float, ...] = shape.size
    elif isinstance(shape, Sphere):
        sizes = (shape.radius,)
    elif isinstance(shape, Plane):
        plane = np.array([shape.a, shape.b, shape.c, shape.d])
        return '' if is_place(plane) else 'its plane is not finite or too large'
    else:
        sizes = (shape.radius, shape.length)
    if not all(0.0 < size <= FARTHEST for size in sizes):
        return f'its dimensions {sizes} have to be finite and above 0'
    return ''


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
    if isinstance(shape, Box):
        return 0.5 * np.asarray(shape.size)
    if isinstance(shape, Sphere):
        return np.full(3, shape.radius)
    if isinstance(shape, Cylinder | Cone):
        return np.array([shape.radius, shape.radius, 0.5 * shape.length])
    if isinstance(shape, Capsule):
        return np.array([shape.radius, shape.radius, 0.5 * shape.length + shape.radius])
    if isinstance(shape, Mesh):
        half: Vector = 0.5 * (shape.vertices.max(axis=0) - shape.vertices.min(axis=0))
        return half
    return np.full(3, 1.0)


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
