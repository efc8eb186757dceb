# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Mesh files to triangles, and meshes to convex parts; what takes long is kept in a cache.

STL and OBJ are read here because every start reads them: importing trimesh alone takes 0.6 s.
COLLADA, glTF and their like are read through Assimp.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
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

from armsim_ros.errors import ResourceError
from armsim_ros.install_rules.view import cache_folder
from armsim_ros.model.geometry import Mesh
from armsim_ros.packages import Packages
from armsim_ros.resources import resolve_uri

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


LARGEST_MESH = 200 << 20
#: Meshes of less surface [m^2] are lines or points: their scale is wrong, or they are empty.
LEAST_AREA = 1e-12
#: Smaller files are read as quickly as what is kept of them.
WORTH_KEEPING = 200 << 10


def load_mesh(uri: str, scale: tuple[float, float, float] = (1.0, 1.0, 1.0), *,
              packages: Packages | Iterable[Path] = (), base: Path | None = None,
              within: Iterable[Path] | None = None) -> Mesh:
    """
    Read a mesh.

    :param uri: ``package://``, ``file://`` or a path.
    :param scale: factors of x, y, z; a negative factor mirrors, and the triangles turn with it.
    :param packages: where packages are searched.
    :param base: the folder that a relative path starts from.
    :param within: the folders that a mesh may lie in; None allows all.
    :raises ResourceError: where there is no such file, or it holds no triangles that we read, or
        triangles without surface.
    """
    file = resolve_uri(uri, packages, base=base, within=within)
    ending = file.suffix.lower()
    if ending not in (*_READERS, *ENDINGS):
        raise ResourceError(
            f"mesh '{uri}': {file.suffix or 'a file without ending'} is not read; allowed: "
            f"{', '.join((*_READERS, *ENDINGS))}; convert it once, e.g. python -c \"import "
            f"trimesh; trimesh.load('{file.name}', force='mesh').export('{file.stem}.stl')\"")
    if file.stat().st_size > LARGEST_MESH:
        raise ResourceError(f"mesh '{uri}' is larger than {LARGEST_MESH >> 20} MiB")
    try:
        read = _READERS.get(ending)
        if read is None:
            vertices, triangles = read_mesh_file(file)
        else:
            data = file.read_bytes()
            large = len(data) >= WORTH_KEEPING
            vertices, triangles = cached(data, ending, read) if large else read(data)
    except (ValueError, IndexError) as error:
        raise ResourceError(f"mesh '{uri}' cannot be read: {error}") from None
    if len(triangles) == 0:
        raise ResourceError(f"mesh '{uri}' has no triangles")
    if not np.isfinite(vertices).all():
        raise ResourceError(f"mesh '{uri}' has a vertex that is not finite")
    factors = np.asarray(scale, dtype=np.float64)
    if np.prod(factors) < 0.0:
        triangles = triangles[:, ::-1]
    mesh = Mesh(vertices * factors, np.ascontiguousarray(triangles), uri)
    if _area(mesh) < LEAST_AREA:
        raise ResourceError(f"mesh '{uri}' has no surface")
    return mesh


def _area(mesh: Mesh) -> float:
    """Return the area of the triangles [m^2]."""
    a, b, c = (mesh.vertices[mesh.triangles[:, corner]] for corner in range(3))
    return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def _read_stl(data: bytes) -> tuple[Vertices, Triangles]:
    count = int.from_bytes(data[80:84], 'little') if len(data) >= 84 else -1
    if len(data) == 84 + 50 * count:
        corners = _binary_corners(data, count)
    elif data.lstrip()[:5].lower() == b'solid':
        corners = _text_corners(data)
    else:
        raise ValueError(f'{len(data)} bytes do not fit the {count} triangles that it announces')
    return _join_equal(corners)


def _binary_corners(data: bytes, count: int) -> Vertices:
    record = np.dtype([('normal', '<f4', 3), ('corners', '<f4', (3, 3)), ('attribute', '<u2')])
    table = np.frombuffer(data, dtype=record, count=count, offset=84)
    return table['corners'].reshape(-1, 3).astype(np.float64)


def _text_corners(data: bytes) -> Vertices:
    words = data.split()
    places = [i for i, word in enumerate(words) if word.lower() == b'vertex']
    if len(places) % 3:
        raise ValueError(f'{len(places)} vertices are not a whole number of triangles')
    numbers = [[float(word) for word in words[i + 1:i + 4]] for i in places]
    return np.array(numbers, dtype=np.float64).reshape(-1, 3)


def _join_equal(corners: Vertices) -> tuple[Vertices, Triangles]:
    """Return vertices without doubles; (3 t, 3) corners make t triangles."""
    vertices, index = np.unique(corners, axis=0, return_inverse=True)
    return vertices, index.reshape(-1, 3).astype(np.int64)


def _read_obj(data: bytes) -> tuple[Vertices, Triangles]:
    vertices: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    for line in data.decode('utf-8', errors='replace').splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] == 'v':
            vertices.append([float(word) for word in words[1:4]])
        elif words[0] == 'f':
            face = [_obj_index(word, len(vertices)) for word in words[1:]]
            triangles += [(face[0], face[i], face[i + 1]) for i in range(1, len(face) - 1)]
    table = np.array(triangles, dtype=np.int64).reshape(-1, 3)
    if len(table) and (table.min() < 0 or table.max() >= len(vertices)):
        raise ValueError('a face names a vertex that is not there')
    return np.array(vertices, dtype=np.float64).reshape(-1, 3), table


def _obj_index(word: str, count: int) -> int:
    """Return the index from 0 of ``v``, ``v/t/n``; negative ones count from the end."""
    number = int(word.split('/')[0])
    return number - 1 if number > 0 else count + number


_READERS: dict[str, Callable[[bytes], tuple[Vertices, Triangles]]] = {
    '.stl': _read_stl, '.obj': _read_obj,
}


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
