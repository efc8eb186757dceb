# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Shapes of links and of objects in the world."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray


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
