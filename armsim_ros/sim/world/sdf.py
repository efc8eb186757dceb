# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Worlds and models in SDF (http://sdformat.org/spec): what rigid objects need.

Read are worlds, gravity, models (nested ones, too), local includes, static, poses with
relative_to, links, inertials, collisions, colours of visuals, the usual shapes and friction. A
model is a rigid object: its links hold together as they are placed. All else is listed as
unused.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
import math
from typing import Any, TypeVar

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.model.description.xml_tree import XmlElement
from armsim_ros.model.geometry import Box, Capsule, Cylinder, Geometry, Mesh, Plane, Sphere
from armsim_ros.model.inertia import combined
from armsim_ros.model.robot_model import Inertial, LinkGeometry
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.sim.world.loaded_world import (
    ASSET_FAULTS,
    check_names,
    Fault,
    LoadedObject,
    LoadedWorld,
    parse,
    ResourceFaultError,
    Unused,
)

Triple = tuple[float, float, float]
Value = TypeVar('Value')
MeshReader = Callable[[str, Triple], Mesh]
#: Returns the text of the model that an address names, and what reads the files it names.
ModelReader = Callable[[str], tuple[str, MeshReader, 'ModelReader']]

#: Mass of a link without ``<inertial>`` [kg], as SDF has it.
DEFAULT_MASS = 1.0
#: Models inside of models, includes counted.
MOST_NESTED = 16

_MODEL = {'static', 'pose', 'link', 'model', 'include', 'frame', 'joint', 'self_collide',
          'allow_auto_disable', 'enable_wind'}
_LINK = {'pose', 'inertial', 'collision', 'visual', 'gravity', 'self_collide', 'kinematic',
         'velocity_decay', 'enable_wind', 'must_be_base_link'}
_WORLD = {'model', 'include', 'gravity', 'physics', 'frame'}


def sdf_object(text: str, file: str, read_mesh: MeshReader, read_model: ModelReader
               ) -> LoadedObject:
    """
    Return the first model of an SDF text as an object.

    :raises ResourceFaultError: the text is wrong; with its line.
    """
    root, unused = parse(text, file), Unused()
    model = root if root.tag == 'model' else root.first('model')
    if model is None:
        raise _refused(root, 'it has no <model>')
    reader = _Reader(read_mesh, read_model, unused, ignore_assets=False)
    item = reader.model(model, _Scope(), 0)
    return LoadedObject(item, unused.lines, tuple(unused.remarks))


def sdf_world(text: str, file: str, read_mesh: MeshReader, read_model: ModelReader, *,
              ignore_assets: bool = False) -> LoadedWorld:
    """
    Return the world of an SDF text.

    :param ignore_assets: leave out meshes and models that are missing or cannot be read.
    :raises ResourceFaultError: the text is wrong; with its line.
    """
    root, unused = parse(text, file), Unused()
    world = root.first('world')
    if world is None:
        raise _refused(root, 'it has no <world>')
    reader = _Reader(read_mesh, read_model, unused, ignore_assets)
    for child in world.children:
        if child.tag not in _WORLD:
            unused.add(_named(child))
    if world.first('physics') is not None:
        unused.add('<physics>: the simulation keeps its own, see simulation.yaml')
    pull = world.first('gravity')
    gravity = None if pull is None else _triple(_floats(pull, 3))
    scope = _Scope.of(world, ('model', 'frame'))
    read = [reader.asset(reader.model, model, scope, 0) for model in world.all('model')]
    read += [reader.asset(reader.include, include, scope, 0) for include in world.all('include')]
    items = [item for item in read if item is not None]
    check_names(items)
    return LoadedWorld(world.get('name') or 'world', tuple(items), False, unused.lines, gravity,
                       tuple(unused.remarks))


@dataclass(eq=False)
class _Scope:
    """Frames that ``relative_to`` may name, by name; '' is where the scope begins."""

    elements: dict[str, XmlElement] = field(default_factory=dict)

    @classmethod
    def of(cls, parent: XmlElement, tags: tuple[str, ...]) -> _Scope:
        return cls({element.get('name'): element for tag in tags for element in parent.all(tag)})

    def pose(self, element: XmlElement, base: str = '', seen: tuple[str, ...] = ()) -> Matrix:
        """
        Return the pose (4, 4) of an element where the scope begins.

        :param base: what it is relative to by default.
        """
        given = element.first('pose')
        local = np.eye(4) if given is None else _pose(given)
        frame = given.get('relative_to') if given is not None else ''
        frame = frame or element.get('attached_to') or base
        if frame in ('', 'world', '__model__'):
            return local
        if frame in seen:
            raise _refused(element, f"frame '{frame}' is relative to itself")
        if frame not in self.elements:
            raise _refused(element, f"relative_to='{frame}' names no frame; allowed: "
                           + (', '.join(self.elements) or 'none'))
        outer: Matrix = self.pose(self.elements[frame], '', (*seen, frame)) @ local
        return outer


class _Reader:
    """Reads models; ``read_mesh`` and ``read_model`` keep to the folders that are allowed."""

    def __init__(self, read_mesh: MeshReader, read_model: ModelReader, unused: Unused,
                 ignore_assets: bool) -> None:
        self._read_mesh, self._read_model, self._unused = read_mesh, read_model, unused
        self._ignore_assets, self._left_out = ignore_assets, 0

    def asset(self, read: Callable[..., Value], *arguments: Any) -> Value | None:
        """Return what is read from a file; None where it is left out."""
        try:
            return read(*arguments)
        except ResourceFaultError as error:
            if not self._ignore_assets or error.fault not in ASSET_FAULTS:
                raise
            self._left_out += 1
            self._unused.add(f'left out: {error}')
            return None

    def include(self, element: XmlElement, scope: _Scope, depth: int) -> WorldObject:
        uri = _text(element, 'uri')
        text, read_mesh, read_model = self._read_model(uri)
        inside = parse(text, uri)
        model = inside if inside.tag == 'model' else inside.first('model')
        if model is None or depth >= MOST_NESTED:
            raise _refused(element, f"'{uri}' holds no <model>" if model is None else
                           'models are nested too deeply')
        reader = _Reader(read_mesh, read_model, self._unused, self._ignore_assets)
        item = reader.model(model, _Scope(), depth + 1)
        static = _flag(element, 'static')
        return WorldObject(
            _text(element, 'name', item.name),
            scope.pose(element) if element.first('pose') is not None else item.pose,
            item.parts, None if static else item.mass, item.friction,
            None if static else item.inertial)

    def model(self, element: XmlElement, outer: _Scope, depth: int) -> WorldObject:
        """Return a model as an object."""
        if depth >= MOST_NESTED:
            raise _refused(element, 'models are nested too deeply')
        name = element.get('name')
        if not name:
            raise _refused(element, 'a <model> has no name')
        left_out = self._left_out
        static = _flag(element, 'static')
        scope = _Scope.of(element, ('link', 'frame', 'model'))
        parts: list[LinkGeometry] = []
        inertials: list[Inertial] = []
        friction: float | None = None
        for child in element.children:
            if child.tag not in _MODEL:
                self._unused.add(f"{_named(child)} of model '{name}'")
            elif child.tag == 'joint' and child.get('type') != 'fixed':
                self._unused.add(f"joint '{child.get('name')}' of type '{child.get('type')}' of "
                                 f"model '{name}': its links hold together")
        for link in element.all('link'):
            pose = scope.pose(link)
            rubbing = self._link(link, pose, parts, inertials, static)
            friction = rubbing if friction is None else friction
        inner = [(scope.pose(child), self.model(child, scope, depth + 1))
                 for child in element.all('model')]
        inner += [(item.pose, item) for item in (
            self.asset(self.include, included, scope, depth + 1)
            for included in element.all('include'))
            if item is not None]
        for pose, item in inner:
            parts += [LinkGeometry(part.geometry, pose @ part.origin, rgba=part.rgba)
                      for part in item.parts]
            if not static and item.inertial is not None:
                inertials.append(Inertial(item.inertial.mass, pose @ item.inertial.origin,
                                          item.inertial.inertia))
        if not parts:
            fault = _refused(element, f"model '{name}' has no <collision> that is read")
            if self._left_out > left_out:
                fault.fault = Fault.MISSING_ASSETS
            raise fault
        if not static and any(isinstance(part.geometry, Plane) for part in parts):
            raise _refused(element, f"model '{name}' has a plane and is not static")
        return self._object(name, outer.pose(element), parts, static, inertials, friction)

    @staticmethod
    def _object(name: str, pose: Matrix, parts: list[LinkGeometry], static: bool,
                inertials: list[Inertial], friction: float | None) -> WorldObject:
        rubbing = 0.8 if friction is None else friction
        if static:
            return WorldObject(name, pose, tuple(parts), None, rubbing)
        whole = combined(inertials) if inertials else None
        mass = DEFAULT_MASS if whole is None else whole.mass
        return WorldObject(name, pose, tuple(parts), mass, rubbing, whole)

    def _link(self, link: XmlElement, pose: Matrix, parts: list[LinkGeometry],
              inertials: list[Inertial], static: bool) -> float | None:
        """Add a link's shapes and mass; return its friction where it has any."""
        friction: float | None = None
        colors = [color for color in map(_color, link.all('visual')) if color is not None]
        for child in link.children:
            if child.tag not in _LINK:
                self._unused.add(f"{_named(child)} of link '{link.get('name')}'")
        for number, collision in enumerate(link.all('collision')):
            geometry, tilt = self._geometry(collision)
            if geometry is None:
                continue
            local = _Scope().pose(collision)
            color = colors[min(number, len(colors) - 1)] if colors else None
            parts.append(LinkGeometry(geometry, pose @ local @ tilt, rgba=color))
            friction = _friction(collision) if friction is None else friction
        inertial = link.first('inertial')
        if inertial is not None and not static:
            inertials.append(_inertial(inertial, pose))
            if inertial.first('mass') is not None and inertial.first('inertia') is None:
                self._unused.remarks.append(
                    f"{inertial.where}: link '{link.get('name')}' has a mass and no <inertia>, "
                    'which SDF takes for 1 kg m^2 about each axis; give its own, or it hardly '
                    'turns')
        return friction

    def _geometry(self, collision: XmlElement) -> tuple[Geometry | None, Matrix]:
        holder = collision.first('geometry')
        shape = holder.children[0] if holder is not None and holder.children else None
        if shape is None:
            raise _refused(collision, f"collision '{collision.get('name')}' has no shape")
        if shape.tag == 'box':
            size = [_positive(shape, number) for number in _numbers(shape, 'size', 3)]
            return Box(_triple(size)), np.eye(4)
        if shape.tag == 'sphere':
            return Sphere(_positive(shape, *_numbers(shape, 'radius', 1))), np.eye(4)
        if shape.tag in ('cylinder', 'capsule'):
            kind = Cylinder if shape.tag == 'cylinder' else Capsule
            radius, length = (_numbers(shape, word, 1)[0] for word in ('radius', 'length'))
            return kind(_positive(shape, radius), _positive(shape, length)), np.eye(4)
        if shape.tag == 'plane':
            a, b, c = _numbers(shape, 'normal', 3, (0.0, 0.0, 1.0))
            if not any((a, b, c)):
                raise _refused(shape, 'the normal of a plane is 0')
            return Plane(a, b, c, 0.0), np.eye(4)
        if shape.tag == 'mesh':
            scale = _triple(_numbers(shape, 'scale', 3, (1.0, 1.0, 1.0)))
            return self.asset(self._read_mesh, _text(shape, 'uri'), scale), np.eye(4)
        self._unused.add(f"shape <{shape.tag}> of collision '{collision.get('name')}'")
        return None, np.eye(4)


def _inertial(element: XmlElement, pose: Matrix) -> Inertial:
    mass = _numbers(element, 'mass', 1, (DEFAULT_MASS,))[0]
    if not mass > 0.0:
        raise _refused(element, f'the mass is {mass:g} kg; allowed: above 0')
    inertia = np.eye(3)
    table = element.first('inertia')
    if table is not None:
        xx, yy, zz, xy, xz, yz = (
            _numbers(table, word, 1, (default,))[0]
            for word, default in (('ixx', 1.0), ('iyy', 1.0), ('izz', 1.0),
                                  ('ixy', 0.0), ('ixz', 0.0), ('iyz', 0.0)))
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Inertial(mass, pose @ _Scope().pose(element), inertia)


def _friction(collision: XmlElement) -> float | None:
    element: XmlElement | None = collision
    for tag in ('surface', 'friction', 'ode', 'mu'):
        element = element.first(tag) if element is not None else None
    if element is None:
        return None
    return min(max(_floats(element, 1)[0], 0.0), 10.0)


def _color(visual: XmlElement) -> tuple[float, float, float, float] | None:
    material = visual.first('material')
    given = material.first('diffuse') if material is not None else None
    if given is None:
        return None
    r, g, b, *rest = (min(max(value, 0.0), 1.0) for value in _floats(given, 3, 4))
    return r, g, b, rest[0] if rest else 1.0


def _pose(element: XmlElement) -> Matrix:
    if not element.content:
        return np.eye(4)
    if element.get('rotation_format') == 'quat_xyzw':
        raise _refused(element, "rotation_format='quat_xyzw' is not read; give euler_rpy")
    values = _floats(element, 6)
    turn = values[3:]
    if element.get('degrees') in ('true', '1'):
        turn = [math.radians(value) for value in turn]
    return pose_matrix(values[:3], turn)


def _text(element: XmlElement, tag: str, default: str | None = None) -> str:
    child = element.first(tag)
    if child is None or not child.content:
        if default is None:
            raise _refused(element, f'<{element.tag}> has no <{tag}>')
        return default
    return child.content


def _flag(element: XmlElement, tag: str) -> bool:
    return _text(element, tag, 'false') in ('true', '1')


def _numbers(element: XmlElement, tag: str, count: int, default: tuple[float, ...] = ()
             ) -> list[float]:
    child = element.first(tag)
    if child is None:
        if not default:
            raise _refused(element, f'<{element.tag}> has no <{tag}>')
        return list(default)
    return _floats(child, count)


def _floats(element: XmlElement, *counts: int) -> list[float]:
    try:
        values = [float(word) for word in element.content.split()]
    except ValueError:
        values = []
    if len(values) not in counts or not all(map(math.isfinite, values)):
        raise _refused(element, f"<{element.tag}> is '{element.content[:60]}'; allowed: "
                       f"{' or '.join(map(str, counts))} finite numbers")
    return values


def _triple(values: list[float]) -> Triple:
    x, y, z = values
    return x, y, z


def _positive(element: XmlElement, value: float) -> float:
    if not value > 0.0:
        raise _refused(element, f'<{element.tag}> has the measure {value:g}; allowed: above 0')
    return value


def _named(element: XmlElement) -> str:
    name = element.get('name')
    return f"<{element.tag} name='{name}'>" if name else f'<{element.tag}>'


def _refused(element: XmlElement, text: str) -> ResourceFaultError:
    return ResourceFaultError(Fault.RESOURCE_PARSE_ERROR, f'{element.where}: {text}')
