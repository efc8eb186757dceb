# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A mesh as convex parts, for physics with convex shapes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsim_ros.model.geometry import Mesh
from armsim_ros.model.mesh.mesh_library import Arrays, cached

#: So many parts has a mesh at most; each costs time in every physics step.
MOST_PARTS = 16
#: Volume elements that a mesh is cut into, and corners that a part has at most.
RESOLUTION, MOST_CORNERS = 100_000, 32
#: A part thinner than this share of its length is none to the physics.
LEAST_THICKNESS = 1e-4


def convex_parts(mesh: Mesh) -> tuple[Mesh, ...]:
    """
    Return convex parts that fill a mesh, made by V-HACD and kept by the mesh's content.

    :returns: at most ``MOST_PARTS``; none where the mesh encloses nothing.
    """
    data = mesh.vertices.tobytes() + mesh.triangles.tobytes()
    arrays = cached(data, '.parts', lambda _: _decompose(mesh))
    return tuple(Mesh(vertices, triangles, mesh.uri)
                 for vertices, triangles in zip(arrays[::2], arrays[1::2], strict=True))


def _decompose(mesh: Mesh) -> Arrays:
    """Return vertices and triangles of the parts, in turn."""
    import vhacdx  # only robots whose hulls overlap pay for its import

    # Each face begins with its number of corners, as in VTK.
    faces = np.insert(mesh.triangles, 0, 3, axis=1).astype(np.uint32)
    parts = vhacdx.compute_vhacd(
        np.ascontiguousarray(mesh.vertices), faces,
        maxConvexHulls=MOST_PARTS, resolution=RESOLUTION, maxNumVerticesPerCH=MOST_CORNERS,
        asyncACD=False)
    found: list[NDArray[np.float64] | NDArray[np.int64]] = []
    for vertices, triangles in parts:
        corners = np.array(vertices, dtype=np.float64)
        if _is_solid(corners):
            found += [corners, np.array(triangles, dtype=np.int64)]
    return found


def _is_solid(corners: NDArray[np.float64]) -> bool:
    if len(corners) < 4:
        return False
    extents = np.linalg.svd(corners - corners.mean(axis=0), compute_uv=False)
    return bool(extents[-1] > LEAST_THICKNESS * extents[0])
