# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Meshes of the formats that a library reads: COLLADA, glTF and their like, through Assimp.

Reading takes up to a second a file, so what was read is kept.
"""

from __future__ import annotations

from pathlib import Path
import re

import numpy as np
from numpy.typing import NDArray

from armsim_ros.model.mesh.mesh_cache import cached

#: Endings of the formats.
ENDINGS = ('.dae', '.glb', '.gltf', '.ply')
#: Formats whose file does not hold all of it, and so does not show whether it has changed.
_OF_SEVERAL_FILES = ('.gltf',)
_UNIT = re.compile(rb'<unit\b[^>]*\bmeter\s*=\s*["\']([^"\']+)["\']')

Vertices = NDArray[np.float64]
Triangles = NDArray[np.int64]


def read_mesh_file(file: Path) -> tuple[Vertices, Triangles]:
    """
    Read a mesh, or take it from the cache.

    The transforms of a scene's nodes are applied and so is the unit of a COLLADA file; its
    ``up_axis`` is not, as in RViz.

    :returns: vertices (v, 3) [m] and triangles (t, 3).
    :raises ValueError: where the library cannot read it.
    """
    data = file.read_bytes()
    ending = file.suffix.lower()

    def read(data: bytes) -> tuple[Vertices, Triangles]:
        vertices, triangles = _read(file)
        return vertices * (_unit(data) if ending == '.dae' else 1.0), triangles

    if ending in _OF_SEVERAL_FILES:
        return read(data)
    vertices, triangles = cached(data, ending, read)
    return vertices, triangles


def _read(file: Path) -> tuple[Vertices, Triangles]:
    import coal  # only robots with such meshes pay for its import, and only once

    try:
        mesh = coal.MeshLoader(coal.BV_AABB).load(str(file), np.ones(3))
    except (RuntimeError, ValueError) as error:
        raise ValueError(' '.join(str(error).split())) from None
    if mesh is None:
        raise ValueError('it holds no triangles')
    faces = (mesh.tri_indices(number) for number in range(mesh.num_tris))
    triangles = np.array([(face[0], face[1], face[2]) for face in faces], dtype=np.int64)
    return np.array(mesh.vertices(), dtype=np.float64), triangles.reshape(-1, 3)


def _unit(data: bytes) -> float:
    """Return the length of a COLLADA file's unit [m]."""
    match = _UNIT.search(data)
    try:
        value = float(match[1]) if match else 1.0
    except ValueError:
        value = 1.0
    return value if value > 0.0 else 1.0
