# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The objects of a world as a text file (``.scene``).

The first line names the scene. Each object is ``* id``, its pose (position and quaternion xyzw
on two lines), the number of its shapes, and for each shape its kind, its dimensions, its pose
on the object and its colour; then the number of subframes with name and pose each. A line with
``.`` ends the file. In files of older programs objects have neither a pose nor subframes; there
a line with the number of shapes follows the id at once.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.model.geometry import (
    Box,
    Cone,
    Cylinder,
    Geometry,
    Mesh,
    Plane,
    shape_fault,
    Sphere,
)
from armsim_ros.model.transforms import quat_xyzw_from_matrix
from armsim_ros.planning.scene.content import Color
from armsim_ros.planning.scene.objects import CollisionObject, message_pose, ObjectShape
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import SceneUpdate

LARGEST_FILE = 200_000_000
"""A file beyond this many bytes is refused."""

_LONGEST_LINE = 10_000
_NO_COLOR: Color = (0.0, 0.0, 0.0, 0.0)


def write_scene_file(path: str, scene: PlanningScene) -> None:
    """
    Write the objects of a scene's world: all of them, or nothing.

    :raises PlanningError: the path is not a place for a file, another kind of file is there, or a
        name does not fit on a line.
    :raises OSError: it cannot be written.
    """
    target = Path(path)
    if target.exists() and not _is_scene_file(target):
        raise _error(f"'{path}' is there and is not a scene file; it is left as it is")
    lines = [_word(scene.name or '(noname)', 'the scene')]
    for item in scene.objects.values():
        lines += _object_lines(item, scene.colors.get(item.id, _NO_COLOR))
    made = target.with_name(f'{target.name}.part')
    try:
        with made.open('x', encoding='utf-8') as file:
            file.write('\n'.join([*lines, '.', '']))
        made.replace(target)
    finally:
        made.unlink(missing_ok=True)


def _is_scene_file(path: Path) -> bool:
    """Return whether a file looks as if this module, or a program like it, had written it."""
    if not path.is_file():
        return False
    with path.open('rb') as file:
        first = file.readline(_LONGEST_LINE)
        second = file.readline(_LONGEST_LINE)
    return not first.strip() or second.startswith(b'* ') or second.strip() == b'.'


def _word(name: str, what: str) -> str:
    """Return a name that fits on a line; PlanningError for any other."""
    if name != name.strip() or len(name.splitlines()) != 1 or '\0' in name:
        raise _error(
            f'the name {name!r} of {what} cannot be saved: a file holds names of one line, '
            'without spaces before or after them')
    return name


def read_scene_file(path: str) -> SceneUpdate:
    """
    Return what a file adds to a world: its objects and their colours.

    :meth:`PlanningScene.load` puts it into a scene.

    :raises PlanningError: the file has another form; the text names the line.
    :raises OSError: it cannot be read.
    """
    source = Path(path)
    if not source.is_file():
        raise _error(f"there is no file '{path}'")
    if source.stat().st_size > LARGEST_FILE:
        raise _error(f"'{path}' is larger than {LARGEST_FILE} bytes")
    try:
        reader = _Reader(path, source.read_text(encoding='utf-8'))
    except UnicodeDecodeError:
        raise _error(f"'{path}' is not a text file") from None
    return reader.scene()


def _object_lines(item: CollisionObject, color: Color) -> Iterator[str]:
    yield f"* {_word(item.id, 'an object')}"
    yield from _pose_lines(item.pose)
    yield str(len(item.shapes))
    for shape in item.shapes:
        yield from _shape_lines(shape.geometry)
        yield from _pose_lines(shape.pose)
        yield _numbers(color)
    yield str(len(item.subframes))
    for name, pose in item.subframes.items():
        yield _word(name, f"a subframe of object '{item.id}'")
        yield from _pose_lines(np.asarray(pose))


def _pose_lines(pose: Matrix) -> tuple[str, str]:
    return _numbers(pose[:3, 3]), _numbers(quat_xyzw_from_matrix(pose))


def _shape_lines(geometry: Geometry) -> Iterator[str]:
    if isinstance(geometry, Box):
        yield from ('box', _numbers(geometry.size))
    elif isinstance(geometry, Sphere):
        yield from ('sphere', _numbers([geometry.radius]))
    elif isinstance(geometry, Cone):
        yield from ('cone', _numbers([geometry.radius, geometry.length]))
    elif isinstance(geometry, Plane):
        yield from ('plane', _numbers([geometry.a, geometry.b, geometry.c, geometry.d]))
    elif isinstance(geometry, Mesh):
        yield from ('mesh', f'{len(geometry.vertices)} {len(geometry.triangles)}')
        yield from map(_numbers, geometry.vertices)
        yield from (' '.join(map(str, row)) for row in geometry.triangles)
    else:
        yield from ('cylinder', _numbers([geometry.radius, geometry.length]))


def _numbers(values: object) -> str:
    return ' '.join(repr(float(value)) for value in np.asarray(values, dtype=np.float64))


class _Reader:
    """The lines of a file, read in order."""

    def __init__(self, path: str, text: str) -> None:
        self._path = path
        self._lines = text.splitlines()
        self._next = 0

    def scene(self) -> SceneUpdate:
        name = self._line('the name of the scene')
        objects: list[CollisionObject] = []
        colors: dict[str, Color] = {}
        while (line := self._line("'* id' or '.'")) != '.':
            if not line.startswith('* '):
                raise self._wrong(f"'{line}'", "'* id' or '.'")
            item, color = self._object(line[2:].strip())
            objects.append(item)
            if color != _NO_COLOR:
                colors[item.id] = color
        return SceneUpdate(name=name, objects=tuple(objects), object_colors=colors)

    def _object(self, name: str) -> tuple[CollisionObject, Color]:
        old = len(self._peek().split()) == 1
        pose = np.eye(4) if old else self._pose()
        shapes: list[ObjectShape] = []
        color = _NO_COLOR
        for _ in range(self._count('the number of shapes', 1)):
            geometry = self._shape()
            shapes.append(ObjectShape(geometry, self._pose()))
            color = self._color()
        frames = {}
        for _ in range(0 if old else self._count('the number of subframes')):
            name_of_frame = self._line('the name of a subframe')
            frames[name_of_frame] = self._pose()
        return CollisionObject(name, pose=pose, shapes=tuple(shapes), subframes=frames), color

    def _shape(self) -> Geometry:
        kind = self._line('the kind of a shape')
        if kind == 'mesh':
            return self._mesh()
        counts = {'box': 3, 'sphere': 1, 'cylinder': 2, 'cone': 2, 'plane': 4}
        if kind not in counts:
            raise self._wrong(f"'{kind}'", ', '.join([*counts, 'mesh']))
        sizes = self._floats(counts[kind], f'the dimensions of a {kind}')
        made: Geometry
        if kind == 'plane':
            made = Plane(sizes[0], sizes[1], sizes[2], sizes[3])
        elif kind == 'box':
            made = Box((sizes[0], sizes[1], sizes[2]))
        elif kind == 'sphere':
            made = Sphere(sizes[0])
        else:
            made = (Cylinder if kind == 'cylinder' else Cone)(radius=sizes[0], length=sizes[1])
        return self._usable(made)

    def _mesh(self) -> Geometry:
        corners, faces = (int(value) for value in self._floats(2, 'two counts of a mesh'))
        if min(corners, faces) < 1 or corners + faces > len(self._lines):
            raise self._wrong(f'{corners} {faces}', 'as many lines as the mesh has parts')
        vertices = np.array([self._floats(3, 'a vertex') for _ in range(corners)])
        triangles = np.array([self._floats(3, 'a triangle') for _ in range(faces)], dtype=np.int64)
        return self._usable(Mesh(vertices, triangles))

    def _usable(self, shape: Geometry) -> Geometry:
        fault = shape_fault(shape)
        if fault:
            raise _error(f'{self._path}:{self._next}: {fault}')
        return shape

    def _pose(self) -> Matrix:
        position = self._floats(3, 'a position')
        quaternion = self._floats(4, 'a quaternion')
        return message_pose(position, quaternion)

    def _color(self) -> Color:
        r, g, b, a = self._floats(4, 'a colour')
        return r, g, b, a

    def _count(self, what: str, least: int = 0) -> int:
        (value,) = self._floats(1, what)
        if value < least or value != int(value) or value > len(self._lines):
            raise self._wrong(f'{value:g}', f'{what}, {least} or more')
        return int(value)

    def _floats(self, count: int, what: str) -> list[float]:
        line = self._line(what)
        try:
            values = [float(word) for word in line.split()]
        except ValueError:
            values = []
        if len(values) != count or not np.isfinite(values).all():
            raise self._wrong(f"'{line}'", f'{what}, {count} numbers')
        return values

    def _peek(self) -> str:
        return self._lines[self._next].strip() if self._next < len(self._lines) else ''

    def _line(self, what: str) -> str:
        if self._next >= len(self._lines):
            raise self._wrong('the end of the file', what)
        self._next += 1
        return self._lines[self._next - 1].strip()

    def _wrong(self, found: str, allowed: str) -> PlanningError:
        return _error(f'{self._path}:{self._next}: {found}; allowed: {allowed}')


def _error(text: str) -> PlanningError:
    return PlanningError(MoveItErrorCode.FAILURE, text, 'scene file')
