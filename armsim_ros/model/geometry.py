# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Shapes of links and of objects in the world, and points of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Matrix, Vector


@dataclass(frozen=True, slots=True)
class Box:
    """A box centred at its frame; ``size`` (x, y, z) [m]."""

    size: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Sphere:
    """A sphere centred at its frame; ``radius`` [m]."""

    radius: float


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder along z, centred at its frame; ``radius``, ``length`` [m]."""

    radius: float
    length: float


@dataclass(frozen=True, slots=True)
class Cone:
    """A cone along z, apex up, centred at half its height; ``radius``, ``length`` [m]."""

    radius: float
    length: float


@dataclass(frozen=True, slots=True)
class Plane:
    """
    The plane ``a*x + b*y + c*z + d = 0``; (a, b, c) is the normal.

    In a planning scene it is infinitely thin; in the simulation all below it is solid.
    """

    a: float
    b: float
    c: float
    d: float


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """
    Triangles.

    :param vertices: (v, 3) [m], scale already applied.
    :param triangles: (t, 3) indices.
    :param uri: where it came from, '' for a mesh given by value.
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    uri: str = ''


@dataclass(frozen=True, slots=True)
class Capsule:
    """A capsule along z, centred at its frame; ``length`` without the caps [m]."""

    radius: float
    length: float


Geometry = Box | Sphere | Cylinder | Cone | Plane | Mesh | Capsule

LARGEST = 1e5
"""Lengths and distances beyond this [m] are treated as errors."""


def shape_fault(shape: Geometry) -> str:
    """Return why a shape cannot be used: no extent, or numbers that are none; '' where it can."""
    if isinstance(shape, Mesh):
        return _mesh_fault(shape)
    if isinstance(shape, Plane):
        normal = math.hypot(shape.a, shape.b, shape.c)
        if not math.isfinite(normal) or not math.isfinite(shape.d) or normal < 1e-9:
            return 'a plane needs finite coefficients and a normal (a, b, c) other than 0'
        far = abs(shape.d) / normal > LARGEST
        return f'the plane lies more than {LARGEST:g} m away' if far else ''
    if isinstance(shape, Box):
        sizes: tuple[float, ...] = shape.size
    elif isinstance(shape, Sphere):
        sizes = (shape.radius,)
    else:
        sizes = (shape.length, shape.radius)
    if not all(math.isfinite(size) and 0.0 < size <= LARGEST for size in sizes):
        return (f'a {type(shape).__name__.lower()} cannot have the dimensions '
                f'{[float(size) for size in sizes]} m; allowed: above 0, up to {LARGEST:g} m')
    return ''


def _mesh_fault(mesh: Mesh) -> str:
    vertices, triangles = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
    if triangles.ndim != 2 or triangles.shape[1:] != (3,) or not len(triangles):
        return 'a mesh needs at least one triangle of three vertices'
    if vertices.ndim != 2 or vertices.shape[1:] != (3,):
        return 'the vertices of a mesh need three coordinates each'
    if not np.isfinite(vertices).all() or np.abs(vertices).max(initial=0.0) > LARGEST:
        return 'the mesh has a vertex that is not finite or too far away'
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        return (f'a triangle of the mesh names vertex {int(triangles.max())}, but there are '
                f'{len(vertices)} vertices')
    return ''


def half_extent(shape: Box | Sphere | Cylinder | Cone | Capsule) -> NDArray[np.float64]:
    """Return half the edges (3,) [m] of the box around a shape, which is in the shape's middle."""
    if isinstance(shape, Box):
        return 0.5 * np.asarray(shape.size)
    if isinstance(shape, Sphere):
        return np.full(3, shape.radius)
    cap = shape.radius if isinstance(shape, Capsule) else 0.0
    return np.array([shape.radius, shape.radius, 0.5 * shape.length + cap])


_SIGNS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
_EPSILON = 1e-9  # [m] that rounding may add


def scaled(geometry: Geometry, scale: float) -> Geometry:
    """Return a shape scaled about its centre; a plane stays as it is."""
    if isinstance(geometry, Box):
        x, y, z = geometry.size
        return Box((x * scale, y * scale, z * scale))
    if isinstance(geometry, Sphere):
        return Sphere(geometry.radius * scale)
    if isinstance(geometry, (Cylinder, Cone, Capsule)):
        return replace(geometry, radius=geometry.radius * scale, length=geometry.length * scale)
    if isinstance(geometry, Mesh):
        centre = np.asarray(geometry.vertices).mean(axis=0)
        return Mesh(centre + (geometry.vertices - centre) * scale, geometry.triangles)
    return geometry


def used_vertices(mesh: Mesh) -> Matrix:
    """Return the vertices (k, 3) [m] of a mesh that belong to triangles, in their order."""
    used = np.zeros(len(mesh.vertices), dtype=bool)
    used[mesh.triangles] = True
    vertices: Matrix = np.asarray(mesh.vertices, np.float64)[used]
    return vertices


def corner_points(geometry: Geometry, pose: Matrix) -> Matrix:
    """
    Return points (k, 3) [m] whose convex hull holds a shape.

    A plane has none; it is infinite and does not move.

    :param pose: (4, 4) of the shape in the frame of the points.
    """
    if isinstance(geometry, Mesh):
        points = used_vertices(geometry)
    elif isinstance(geometry, Plane):
        return np.empty((0, 3))
    else:
        points = _SIGNS * half_extent(geometry)
    corners: Matrix = points @ pose[:3, :3].T + pose[:3, 3]
    return corners


def lowest_height(geometry: Geometry, pose: Matrix) -> float:
    """
    Return the least z of a shape [m]; that of a plane is infinite, as it does not move.

    :param pose: (4, 4) of the shape.
    """
    height = float(pose[2, 3])
    down = np.abs(pose[2, :3])
    around = float(np.hypot(pose[2, 0], pose[2, 1]))
    if isinstance(geometry, Mesh):
        return float(corner_points(geometry, pose)[:, 2].min())
    if isinstance(geometry, Plane):
        return math.inf
    if isinstance(geometry, Sphere):
        return height - geometry.radius
    if isinstance(geometry, Capsule):
        return height - geometry.radius - 0.5 * geometry.length * float(down[2])
    if isinstance(geometry, Cylinder):
        return height - geometry.radius * around - 0.5 * geometry.length * float(down[2])
    if isinstance(geometry, Cone):
        tip = 0.5 * geometry.length * float(pose[2, 2])
        return height + min(tip, -tip - geometry.radius * around)
    return height - float(down @ half_extent(geometry))


def bounding_box(shape: Geometry) -> tuple[Vector, Vector]:
    """Return middle and half edges (3,) [m] of a shape's box; of a plane, 1 m about its frame."""
    if isinstance(shape, Mesh):
        low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
        return 0.5 * (low + high), 0.5 * (high - low)
    return np.zeros(3), np.ones(3) if isinstance(shape, Plane) else half_extent(shape)


def is_inside(shape: Geometry, point: Vector) -> bool:
    """Return whether a point (3,) [m] in a shape's frame lies in it, its border included."""
    x, y, z = (float(part) for part in point)
    radius = math.hypot(x, y)
    if isinstance(shape, Box):
        return bool(np.all(np.abs(point) <= 0.5 * np.asarray(shape.size) + _EPSILON))
    if isinstance(shape, Sphere):
        return math.hypot(radius, z) <= shape.radius + _EPSILON
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


def nearest_inside(shape: Geometry, point: Vector, margin: float = 0.0) -> Vector:
    """
    Return the nearest point (3,) of a box, ball or cylinder; of others, the point or the middle.

    :param point: (3,) [m] in the shape's frame.
    :param margin: share 0..1 by which a box, ball or cylinder is taken smaller.
    """
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
    return point if is_inside(shape, point) else bounding_box(shape)[0]


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
        + np.einsum('ij,ij->i', c, a) * lb)
    return abs(float(np.sum(np.arctan2(volume, rest)))) / (2.0 * math.pi)
