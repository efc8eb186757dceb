# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Meshes of the formats that a library reads: COLLADA, glTF and their like, through Assimp.

Reading takes up to a second a file, so what was read is kept.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
import hashlib
import io
import os
from pathlib import Path
import re
import tempfile
from typing import Any
import zipfile

import numpy as np
from numpy.typing import NDArray

from armsim_ros.install_rules.view import cache_folder

#: Changes when what is kept changes its meaning.
_VERSION = 'v2'

Arrays = Sequence[NDArray[Any]]


def cached(data: bytes, ending: str, make: Callable[[bytes], Arrays]) -> Arrays:
    """
    Return the arrays that were made of these bytes before, else make them and keep them.

    :param ending: the kind of result; the same bytes may differ in another format.
    :raises ValueError: where ``make`` does.
    """
    digest = hashlib.sha256(data).hexdigest()
    kept = cache_folder('meshes') / f'{_VERSION}-{digest}{ending}.npz'
    found = _load(kept)
    if found is None:
        found = make(data)
        _keep(kept, found)
    return found


def _load(kept: Path) -> Arrays | None:
    try:
        with np.load(io.BytesIO(kept.read_bytes()), allow_pickle=False) as arrays:
            return [arrays[f'arr_{number}'] for number in range(len(arrays.files))]
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None


def _keep(kept: Path, arrays: Arrays) -> None:
    """Keep arrays; where the folder cannot be written they are made anew the next time."""
    try:
        kept.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=kept.parent, suffix='.npz', delete=False) as stream:
            np.savez(stream, *arrays)
        os.replace(stream.name, kept)
    except OSError:
        return


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
