# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How much room an object takes that is not in a world."""

from __future__ import annotations

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.model.geometry import Geometry, half_extent, Mesh, Plane
from armsim_ros.model.world_objects import WorldObject


def object_bounds(item: WorldObject) -> tuple[Matrix, Matrix]:
    """Return the smallest and the largest corner of an object in its own axes, (3,) each [m]."""
    corners = []
    for part in item.parts:
        if isinstance(part.geometry, Plane):
            continue
        low, high = _bounds(part.geometry)
        middle = part.origin[:3, :3] @ (0.5 * (low + high)) + part.origin[:3, 3]
        reach = np.abs(part.origin[:3, :3]) @ (0.5 * (high - low))
        corners += [middle - reach, middle + reach]
    if not corners:
        return np.zeros(3), np.zeros(3)
    return np.min(corners, axis=0), np.max(corners, axis=0)


def _bounds(geometry: Geometry) -> tuple[Matrix, Matrix]:
    if isinstance(geometry, Mesh):
        return geometry.vertices.min(axis=0), geometry.vertices.max(axis=0)
    assert not isinstance(geometry, Plane)
    half = half_extent(geometry)
    return -half, half
