# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Shapes of links and objects for coal: as they are, or as their convex hulls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
import hashlib
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
    Sphere,
    used_vertices,
)

#: Half the thickness [m] that the bounding box of a flat mesh gets: Pinocchio's managers take a
#: shape whose box has no volume for nothing.
LEAST_THICKNESS = 1e-6
#: Meshes of each kind that are kept prepared; the least used go first.
KEPT_MESHES = 256


@dataclass(frozen=True, slots=True)
class _MeshContent:
    """A mesh; it equals all others with the same digest of vertices and triangles."""

    digest: bytes
    mesh: Mesh = field(compare=False)

    @classmethod
    def of(cls, mesh: Mesh) -> _MeshContent:
        digest = hashlib.sha256(np.ascontiguousarray(mesh.vertices, dtype=np.float64).tobytes())
        digest.update(np.ascontiguousarray(mesh.triangles, dtype=np.int64).tobytes())
        return cls(digest.digest(), mesh)


def exact_shape(geometry: Geometry) -> Any:
    """
    Return the shape itself for coal: primitives are exact, meshes are their triangles.

    A plane and a mesh are surfaces: a shape that is wholly on one side or inside of them does not
    touch them.
    """
    if isinstance(geometry, Mesh):
        return _triangles(_MeshContent.of(geometry))
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
    return coal.Plane(normal / length, -geometry.d / length)


def hull_shape(geometry: Geometry) -> Any:
    """Return the convex hull of a mesh, or the exact shape of anything else or of a flat mesh."""
    if isinstance(geometry, Mesh):
        return _hull(_MeshContent.of(geometry))
    return exact_shape(geometry)


@lru_cache(KEPT_MESHES)
def _triangles(content: _MeshContent) -> Any:
    mesh = content.mesh
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


@lru_cache(KEPT_MESHES)
def _hull(content: _MeshContent) -> Any:
    mesh = content.mesh
    used = used_vertices(mesh)
    centred = used - used.mean(axis=0)
    extent = np.linalg.svd(centred, compute_uv=False)
    if len(used) < 4 or extent[2] < 1e-6 * max(float(extent[0]), 1e-9):
        return _triangles(content)  # a flat mesh has no hull with a volume
    points = coal.StdVec_Vec3s()
    points.extend(list(used))
    return coal.ConvexBase.convexHull(points, True, 'Qt')


def are_apart(
    first: Sequence[tuple[Geometry, Matrix]], second: Sequence[tuple[Geometry, Matrix]],
    distance: float
) -> bool:
    """
    Return whether no shape of a body is near a shape of another.

    :param first: shapes with their poses (4, 4) in a common frame; as ``second``.
    :param distance: [m] that is not near.
    """
    request = coal.DistanceRequest()
    for shape, pose in first:
        for other, other_pose in second:
            result = coal.DistanceResult()
            coal.distance(
                exact_shape(shape), coal.Transform3s(pose[:3, :3], pose[:3, 3]),
                exact_shape(other), coal.Transform3s(other_pose[:3, :3], other_pose[:3, 3]),
                request, result)
            if result.min_distance < distance:
                return False
    return True
