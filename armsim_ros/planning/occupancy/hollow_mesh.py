# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which points are inside of a mesh that is not convex, such as a bin."""

from __future__ import annotations

from typing import Any

import coal
import numpy as np

from armsim_ros.arrays import Mask, Matrix
from armsim_ros.model.coal_shapes import exact_shape, hull_shape
from armsim_ros.model.geometry import Mesh

#: Edge of a voxel [m], and most of them along an axis.
_VOXEL, _MOST_VOXELS = 0.005, 96
#: Share of its hull that a mesh fills where it counts as convex.
_CONVEX = 0.99
_UNKNOWN, _OUTSIDE, _INSIDE = range(3)


def is_hollow(mesh: Mesh) -> bool:
    """Return whether the hull of a mesh holds more than the mesh."""
    hull: Any = hull_shape(mesh)
    return hasattr(hull, 'polygons') and not (
        _closed(mesh) and abs(_volume(mesh)) >= _CONVEX * hull.computeVolume())


def _closed(mesh: Mesh) -> bool:
    """Return whether each edge has two triangles, or more where closed parts touch."""
    _, corner = np.unique(np.round(mesh.vertices, 9), axis=0, return_inverse=True)
    triangles = corner.reshape(-1)[mesh.triangles]
    edges = np.sort(np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    return bool((np.unique(edges, axis=0, return_counts=True)[1] % 2 == 0).all())


def _volume(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    return float(np.einsum('ij,ij->', a, np.cross(b, c))) / 6.0


class HollowMesh:
    """
    A mesh whose voxels are classified by their centres when they are first asked for.

    A point is inside where its voxel's centre is within an offset of a triangle, or, in a closed
    mesh, behind the nearest one.

    :param mesh: the shape.
    :param offset: [m] by which it is grown.
    """

    def __init__(self, mesh: Mesh, offset: float) -> None:
        self._shape, self._offset = exact_shape(mesh), offset
        self._low = mesh.vertices.min(axis=0) - offset
        size = mesh.vertices.max(axis=0) + offset - self._low
        self._edge = max(_VOXEL, float(size.max()) / _MOST_VOXELS)
        self._voxels = np.full(
            np.floor(size / self._edge).astype(np.int64) + 1, _UNKNOWN, dtype=np.uint8)
        a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
        outwards = np.sign(_volume(mesh)) if _closed(mesh) else 0.0
        self._normals: Matrix = outwards * np.cross(b - a, c - a)

    def holds(self, points: Matrix) -> Mask:
        """Return which points (k, 3) [m] in the mesh's frame are inside, to within a voxel."""
        places = np.floor((points - self._low) / self._edge).astype(np.int64)
        inside: Mask = ((places >= 0) & (places < self._voxels.shape)).all(axis=1)
        asked = tuple(places[inside].T)
        new = np.unique(places[inside][self._voxels[asked] == _UNKNOWN], axis=0)
        for place in new:
            self._voxels[tuple(place)] = self._classified(
                self._low + (place + 0.5) * self._edge)
        inside[inside] = self._voxels[asked] == _INSIDE
        return inside

    def _classified(self, centre: Matrix) -> int:
        result = coal.DistanceResult()
        distance = coal.distance(
            self._shape, coal.Transform3s(np.eye(3), np.zeros(3)), _POINT,
            coal.Transform3s(np.eye(3), centre), coal.DistanceRequest(), result)
        behind = self._normals[result.b1] @ (centre - result.getNearestPoint1()) < 0.0
        return _INSIDE if distance <= self._offset or behind else _OUTSIDE


_POINT = coal.Sphere(1e-9)
