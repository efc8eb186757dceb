# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Shapes as coal knows them; meshes are prepared once and kept by their content."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import replace
import hashlib
import threading
from typing import Any

import coal
import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.model.geometry import (
    Box,
    Capsule,
    Cone,
    Cylinder,
    Geometry,
    Mesh,
    Plane,
    Sphere,
)

_SIGNS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)

#: Half the thickness [m] that the bounding box of a flat mesh gets: Pinocchio's managers take a
#: shape whose box has no volume for nothing.
LEAST_THICKNESS = 1e-6
#: Prepared meshes that are kept; the least used go first.
KEPT_MESHES = 256


class _MeshCache:
    """Bounding volume hierarchies and convex hulls by content."""

    def __init__(self) -> None:
        self._items: OrderedDict[tuple[str, str], Any] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, kind: str, mesh: Mesh, build: Callable[[], Any]) -> Any:
        key = (kind, _digest(mesh))
        with self._lock:
            if key in self._items:
                self._items.move_to_end(key)
                return self._items[key]
            made = self._items[key] = build()
            while len(self._items) > KEPT_MESHES:
                self._items.popitem(last=False)
            return made


_cache = _MeshCache()


def _digest(mesh: Mesh) -> str:
    digest = hashlib.sha256(np.ascontiguousarray(mesh.vertices, dtype=np.float64).tobytes())
    digest.update(np.ascontiguousarray(mesh.triangles, dtype=np.int64).tobytes())
    return digest.hexdigest()


def exact_shape(geometry: Geometry) -> Any:
    """
    Return the shape itself for coal: primitives are exact, meshes are their triangles.

    A plane is the half space below it. A mesh is a surface: what is wholly inside of it does
    not touch it.
    """
    if isinstance(geometry, Mesh):
        return _cache.get('triangles', geometry, lambda: _triangles(geometry))
    if isinstance(geometry, Box):
        return coal.Box(*geometry.size)
    if isinstance(geometry, Sphere):
        return coal.Sphere(geometry.radius)
    if isinstance(geometry, Cylinder):
        return coal.Cylinder(geometry.radius, geometry.length)
    if isinstance(geometry, Cone):
        return coal.Cone(geometry.radius, geometry.length)
    if isinstance(geometry, Capsule):
        return coal.Capsule(geometry.radius, geometry.length)
    normal = np.array([geometry.a, geometry.b, geometry.c])
    length = float(np.linalg.norm(normal))
    return coal.Halfspace(normal / length, -geometry.d / length)


def hull_shape(geometry: Geometry) -> Any:
    """Return the convex hull of a mesh, or the exact shape of anything else or of a flat mesh."""
    if isinstance(geometry, Mesh):
        return _cache.get('hull', geometry, lambda: _hull(geometry))
    return exact_shape(geometry)


def _triangles(mesh: Mesh) -> Any:
    vertices = np.ascontiguousarray(mesh.vertices, dtype=np.float64)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    flat = high - low < LEAST_THICKNESS
    if flat.any():
        # Vertices of no triangle only count for the bounding box.
        thick = np.where(flat, LEAST_THICKNESS, 0.0)
        vertices = np.vstack([vertices, low - thick, high + thick])
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(mesh.triangles), len(vertices))
    model.addVertices(vertices)
    model.addTriangles(np.ascontiguousarray(mesh.triangles, dtype=np.int64))
    model.endModel()
    model.computeLocalAABB()
    return model


def _hull(mesh: Mesh) -> Any:
    used = np.asarray(mesh.vertices, dtype=np.float64)[np.unique(mesh.triangles)]
    centred = used - used.mean(axis=0)
    extent = np.linalg.svd(centred, compute_uv=False)
    if len(used) < 4 or extent[2] < 1e-6 * max(float(extent[0]), 1e-9):
        return _triangles(mesh)  # a flat mesh has no hull with a volume
    points = coal.StdVec_Vec3s()
    points.extend(list(used))
    return coal.ConvexBase.convexHull(points, True, 'Qt')


def scaled(geometry: Geometry, scale: float) -> Geometry:
    """Return a shape scaled about its centre; a plane stays as it is."""
    if isinstance(geometry, Box):
        x, y, z = geometry.size
        return Box((x * scale, y * scale, z * scale))
    if isinstance(geometry, Sphere):
        return Sphere(geometry.radius * scale)
    if isinstance(geometry, (Cylinder, Cone, Capsule)):
        return replace(
            geometry, radius=geometry.radius * scale, length=geometry.length * scale
        )
    if isinstance(geometry, Mesh):
        centre = np.asarray(geometry.vertices).mean(axis=0)
        return Mesh(centre + (geometry.vertices - centre) * scale, geometry.triangles)
    return geometry


def corner_points(geometry: Geometry) -> Matrix:
    """
    Return points (k, 3) whose convex hull holds the shape, in the shape's frame.

    A plane has none; it is infinite and does not move.
    """
    if isinstance(geometry, Mesh):
        used: Matrix = np.asarray(geometry.vertices, np.float64)[np.unique(geometry.triangles)]
        return used
    if isinstance(geometry, Box):
        half = np.array(geometry.size) / 2.0
    elif isinstance(geometry, Sphere):
        half = np.full(3, geometry.radius)
    elif isinstance(geometry, Capsule):
        half = np.array(
            [geometry.radius, geometry.radius, geometry.length / 2.0 + geometry.radius]
        )
    elif isinstance(geometry, Plane):
        return np.empty((0, 3))
    else:
        half = np.array([geometry.radius, geometry.radius, geometry.length / 2.0])
    corners: Matrix = _SIGNS * half
    return corners


__all__ = ['corner_points', 'exact_shape', 'hull_shape', 'scaled']
