# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Shapes as coloured triangles."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
import trimesh
from trimesh.visual import ColorVisuals

from armsim_ros.errors import ResourceError
from armsim_ros.model.geometry import Box, Capsule, Cone, Cylinder, Geometry, Mesh, Plane, Sphere
from armsim_ros.model.robot_model import Link, LinkGeometry
from armsim_ros.packages import Packages
from armsim_ros.resources import resolve_uri

Color = tuple[int, int, int]

#: Files that are read as meshes; no other file is opened.
MESH_ENDINGS = ('.stl', '.obj', '.dae', '.ply', '.glb')
#: A file larger than this is not read [bytes].
LARGEST_FILE = 100 << 20
#: What has no colour of its own.
PLAIN: Color = (178, 184, 192)
#: Side of the square that represents a plane [m].
PLANE_SIZE = 4.0
#: Corners of a circle.
_SECTIONS = 32


@dataclass(frozen=True, eq=False)
class Surface:
    """
    Triangles of the same colour, in the frame of the shape.

    :param vertices: (v, 3) [m].
    :param faces: (f, 3) indices.
    :param color: None where neither the file nor the description gives a color.
    :param smooth: whether the surface is round; flat faces where not.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]
    color: Color | None = None
    smooth: bool = False
    opacity: float = 1.0


class ShapeReader:
    """Turns geometry into parts; each mesh file is read once."""

    def __init__(self, packages: Packages | None = None) -> None:
        self._packages = packages or Packages()
        self._read: dict[str, tuple[Surface, ...]] = {}

    def shapes_of(self, link: Link) -> tuple[list[tuple[LinkGeometry, tuple[Surface, ...]]],
                                             list[str]]:
        """
        Return the drawn shapes of a link: its visual shapes, else its collision shapes.

        :returns: the shapes with their parts, and messages about what could not be read.
        """
        complaints: list[str] = []
        for shapes in (link.visuals, link.collisions):
            found = []
            for shape in shapes:
                try:
                    found.append((shape, self.parts(shape.geometry, shape.rgba)))
                except ResourceError as error:
                    complaints.append(str(error))
            if found:
                return found, complaints
        return [], complaints

    def parts(self, geometry: Geometry, rgba: tuple[float, ...] | None = None
              ) -> tuple[Surface, ...]:
        """
        Return a shape's triangles.

        :param rgba: a colour that the description gives; it wins over that of a file.
        :raises ResourceError: a mesh file is not there or holds no mesh.
        """
        if isinstance(geometry, Mesh):
            parts = self._mesh(geometry)
        else:
            parts = (_primitive(geometry),)
        if rgba is None:
            return parts
        color = rgb(rgba)
        return tuple(Surface(part.vertices, part.faces, color, part.smooth, float(rgba[3]))
                     for part in parts)

    def _mesh(self, mesh: Mesh) -> tuple[Surface, ...]:
        if len(mesh.triangles):
            return (Surface(mesh.vertices.astype(np.float32), mesh.triangles.astype(np.uint32)),)
        if mesh.uri not in self._read:
            self._read[mesh.uri] = self._file(mesh.uri)
        scale = mesh.vertices[0].astype(np.float32)
        mirrored = float(np.prod(scale)) < 0.0
        return tuple(
            Surface(part.vertices * scale, part.faces[:, ::-1] if mirrored else part.faces,
                 part.color, part.smooth, part.opacity)
            for part in self._read[mesh.uri])

    def _file(self, uri: str) -> tuple[Surface, ...]:
        ending = Path(uri).suffix.lower()
        if ending not in MESH_ENDINGS:
            raise ResourceError(f"mesh '{uri}' is not shown; allowed: {', '.join(MESH_ENDINGS)}")
        file = resolve_uri(uri, self._packages)
        if file.stat().st_size > LARGEST_FILE:
            raise ResourceError(f"mesh '{uri}' is larger than {LARGEST_FILE >> 20} MiB")
        try:
            return parts_of_file(file.read_bytes(), ending[1:])
        except Exception as error:  # noqa: BLE001 - the readers raise what they like
            raise ResourceError(f"mesh '{uri}' cannot be read: {error}") from None


def parts_of_file(data: bytes, kind: str) -> tuple[Surface, ...]:
    """
    Return the triangles in the bytes of a mesh file, a part for each colour.

    :param kind: the file's ending without its dot.
    :raises ValueError: there are no triangles in it.
    """
    loaded = trimesh.load_scene(trimesh.util.wrap_as_stream(data), file_type=kind)
    parts = []
    for item in loaded.dump():
        if isinstance(item, trimesh.Trimesh) and len(item.faces):
            parts.append(Surface(
                np.asarray(item.vertices, np.float32), np.asarray(item.faces, np.uint32),
                _material_color(item), smooth=kind in ('dae', 'glb')))
    if not parts:
        raise ValueError('it has no triangles')
    if not all(np.isfinite(part.vertices).all() for part in parts):
        raise ValueError('it has a vertex that is not finite')
    return tuple(parts)


def rgb(rgba: Iterable[float]) -> Color:
    """Return a colour of numbers 0..1 as a colour of 0..255."""
    r, g, b = (round(255 * min(1.0, max(0.0, float(part)))) for part in list(rgba)[:3])
    return r, g, b


def _primitive(geometry: Geometry) -> Surface:
    smooth = not isinstance(geometry, (Box, Plane))
    if isinstance(geometry, Box):
        solid = trimesh.creation.box(geometry.size)
    elif isinstance(geometry, Sphere):
        solid = trimesh.creation.icosphere(3, geometry.radius)
    elif isinstance(geometry, Cylinder):
        solid = trimesh.creation.cylinder(geometry.radius, geometry.length, _SECTIONS)
        smooth = False
    elif isinstance(geometry, Capsule):
        solid = trimesh.creation.capsule(geometry.length, geometry.radius)
    elif isinstance(geometry, Cone):
        solid = trimesh.creation.cone(geometry.radius, geometry.length, _SECTIONS)
        solid.apply_translation((0.0, 0.0, -0.5 * geometry.length))
        smooth = False
    elif isinstance(geometry, Plane):
        solid = _plane(geometry)
    else:
        raise ResourceError(f'{type(geometry).__name__} is not a shape that is shown')
    return Surface(np.asarray(solid.vertices, np.float32), np.asarray(solid.faces, np.uint32),
                smooth=smooth)


def _plane(plane: Plane) -> trimesh.Trimesh:
    normal = np.array([plane.a, plane.b, plane.c])
    length = float(np.linalg.norm(normal)) or 1.0
    sheet: trimesh.Trimesh = trimesh.creation.box((PLANE_SIZE, PLANE_SIZE, 1e-4))
    turn = trimesh.geometry.align_vectors(  # type: ignore[no-untyped-call] # trimesh's
        (0.0, 0.0, 1.0), normal / length)
    sheet.apply_transform(turn)
    sheet.apply_translation(-plane.d / length**2 * normal)
    return sheet


def _material_color(mesh: trimesh.Trimesh) -> Color | None:
    """Return the colour of a mesh's material, None where the file gives none."""
    material = getattr(mesh.visual, 'material', None)
    if material is not None and getattr(material, 'main_color', None) is not None:
        r, g, b = (int(part) for part in material.main_color[:3])
        return r, g, b
    visual = mesh.visual
    if isinstance(visual, ColorVisuals) and visual.defined and visual.kind in ('vertex', 'face'):
        r, g, b = (int(part) for part in visual.main_color[:3])
        return r, g, b
    return None
