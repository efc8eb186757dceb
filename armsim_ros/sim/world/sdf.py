# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Worlds and models in SDF (http://sdformat.org/spec): what rigid objects need.

Read are worlds, gravity, models (nested ones, too), local includes, static, poses with
relative_to, placement frames, links with or without gravity, inertials (automatic ones, too),
collisions, colours of visuals, the usual shapes and friction. A model is a rigid object: its links
hold together as they are placed. All else is listed as unused.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
import math
from typing import Any, TypeVar

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.errors import SimulationError
from armsim_ros.model.description.xml_tree import XmlElement
from armsim_ros.model.geometry import Box, Capsule, Cylinder, Geometry, Mesh, Plane, Sphere
from armsim_ros.model.inertia import combined, inertial_of
from armsim_ros.model.robot_model import Inertial, LinkGeometry
from armsim_ros.model.transforms import inverse_pose
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.sim.physics.geoms import solid_inertial, volume
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
from armsim_ros.sim.world.sdf_elements import (
    auto_of,
    color_of,
    flag_of,
    floats_of,
    named,
    numbers_of,
    pose_of,
    positive,
    refused,
    text_of,
    Triple,
    triple,
)

Value = TypeVar('Value')
MeshReader = Callable[[str, Triple], Mesh]
#: Returns the text of the model that an address names, and what reads the files it names.
ModelReader = Callable[[str], tuple[str, MeshReader, 'ModelReader']]

#: Mass of a link without ``<inertial>`` [kg], density of an automatic one [kg/m^3], and friction
#: of a shape without ``<mu>``, as SDF has them.
DEFAULT_MASS, DEFAULT_DENSITY, DEFAULT_FRICTION = 1.0, 1000.0, 1.0
#: Models inside of models, includes counted.
MOST_NESTED = 16

_MODEL = {'static', 'pose', 'link', 'model', 'include', 'frame', 'joint', 'self_collide',
          'allow_auto_disable', 'enable_wind'}
_LINK = {'pose', 'inertial', 'collision', 'visual', 'gravity', 'self_collide', 'kinematic',
         'velocity_decay', 'enable_wind', 'must_be_base_link'}
_INCLUDE = {'uri', 'name', 'pose', 'static'}
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
        raise refused(root, 'it has no <model>')
    reader = _Reader(read_mesh, read_model, unused, ignore_assets=False)
    item = reader.model(model, _Scope().pose(model), 0)
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
        raise refused(root, 'it has no <world>')
    reader = _Reader(read_mesh, read_model, unused, ignore_assets)
    for child in world.children:
        if child.tag not in _WORLD:
            unused.add(named(child))
    if world.first('physics') is not None:
        unused.add('<physics>: the simulation keeps its own, see simulation.yaml')
    pull = world.first('gravity')
    gravity = None if pull is None else triple(floats_of(pull, 3))
    scope = _Scope.of(world, ('model', 'frame'))
    read = [reader.asset(reader.model, model, scope.pose(model), 0)
            for model in world.all('model')]
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
        local = np.eye(4) if given is None else pose_of(given)
        frame = given.get('relative_to') if given is not None else ''
        frame = frame or element.get('attached_to') or base
        if frame in ('', 'world', '__model__'):
            return local
        if frame in seen:
            raise refused(element, f"frame '{frame}' is relative to itself")
        placed: Matrix = self.frame(element, frame, seen) @ local
        return placed

    def frame(self, element: XmlElement, name: str, seen: tuple[str, ...] = ()) -> Matrix:
        """
        Return the pose (4, 4) of a frame where the scope begins.

        :param element: names it.
        """
        if name not in self.elements:
            raise refused(element, f"'{name}' names no frame; allowed: "
                          + (', '.join(self.elements) or 'none'))
        return self.pose(self.elements[name], '', (*seen, name))


@dataclass(eq=False)
class _Contents:
    """
    What the links of a model hold.

    :param static: whether it never moves.
    :param floating: mass on which gravity does not act [kg].
    """

    static: bool
    parts: list[LinkGeometry] = field(default_factory=list)
    inertials: list[Inertial] = field(default_factory=list)
    floating: float = 0.0
    friction: float | None = None

    def add_inertial(self, inertial: Inertial, gravcomp: float) -> None:
        """
        Add a mass.

        :param gravcomp: share of its weight that does not act.
        """
        self.inertials.append(inertial)
        self.floating += gravcomp * inertial.mass

    def add(self, item: WorldObject) -> None:
        """Add a model inside of the model; if it is fixed, the whole is."""
        self.parts += [LinkGeometry(part.geometry, item.pose @ part.origin, rgba=part.rgba)
                       for part in item.parts]
        if item.inertial is None:
            self.static = True
        else:
            self.add_inertial(Inertial(item.inertial.mass, item.pose @ item.inertial.origin,
                                       item.inertial.inertia), item.gravcomp)

    def item(self, name: str, pose: Matrix) -> WorldObject:
        """Return the object."""
        friction = DEFAULT_FRICTION if self.friction is None else self.friction
        if self.static:
            return WorldObject(name, pose, tuple(self.parts), None, friction)
        whole = combined(self.inertials)
        return WorldObject(name, pose, tuple(self.parts), whole.mass, friction, whole,
                           self.floating / whole.mass)


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
        uri = text_of(element, 'uri')
        text, read_mesh, read_model = self._read_model(uri)
        inside = parse(text, uri)
        model = inside if inside.tag == 'model' else inside.first('model')
        if model is None:
            raise refused(element, f"'{uri}' holds no <model>")
        for child in element.children:
            if child.tag not in _INCLUDE:
                self._unused.add(f"{named(child)} of the <include> of '{uri}'")
        placed = element.first('pose') is not None
        reader = _Reader(read_mesh, read_model, self._unused, self._ignore_assets)
        item = reader.model(
            model, scope.pose(element) if placed else _Scope().pose(model), depth + 1,
            static=flag_of(element, 'static'))
        return replace(item, name=text_of(element, 'name', item.name))

    def model(self, element: XmlElement, pose: Matrix, depth: int, *, static: bool = False
              ) -> WorldObject:
        """
        Return a model as an object.

        :param pose: (4, 4) of the model, or of its placement frame.
        :param static: whether it never moves, even if it may by its own words.
        """
        if depth >= MOST_NESTED:
            raise refused(element, 'models are nested too deeply')
        name = element.get('name')
        if not name:
            raise refused(element, 'a <model> has no name')
        left_out = self._left_out
        scope = _Scope.of(element, ('link', 'frame', 'model'))
        contents = _Contents(static or flag_of(element, 'static'))
        for child in element.children:
            if child.tag not in _MODEL:
                self._unused.add(f"{named(child)} of model '{name}'")
            elif child.tag == 'joint' and child.get('type') != 'fixed':
                self._unused.add(f"joint '{child.get('name')}' of type '{child.get('type')}' of "
                                 f"model '{name}': its links hold together")
        for link in element.all('link'):
            self._link(link, scope.pose(link), contents)
        for child in element.all('model'):
            contents.add(self.model(child, scope.pose(child), depth + 1))
        for included in element.all('include'):
            item = self.asset(self.include, included, scope, depth + 1)
            if item is not None:
                contents.add(item)
        if not contents.parts:
            fault = refused(element, f"model '{name}' has no <collision> that is read")
            if self._left_out > left_out:
                fault.fault = Fault.MISSING_ASSETS
            raise fault
        frame = element.get('placement_frame')
        if frame:
            pose = pose @ inverse_pose(scope.frame(element, frame))
        return contents.item(name, pose)

    def _link(self, link: XmlElement, pose: Matrix, contents: _Contents) -> None:
        """Add a link's shapes, mass and friction."""
        name = link.get('name')
        for child in link.children:
            if child.tag not in _LINK:
                self._unused.add(f"{named(child)} of link '{name}'")
        if flag_of(link, 'kinematic'):
            contents.static = True
            self._unused.remarks.append(f"{link.where}: link '{name}' is kinematic, so its model "
                                        'is fixed; it can be placed and has no velocity')
        colors = [color for color in map(color_of, link.all('visual')) if color is not None]
        parts: list[LinkGeometry] = []
        densities: list[float] = []
        for number, collision in enumerate(link.all('collision')):
            geometry, tilt = self._geometry(collision)
            if geometry is None:
                continue
            if isinstance(geometry, Plane) and not contents.static:
                raise refused(collision, 'a plane belongs to a static model; this is not static')
            local = _Scope().pose(collision)
            color = colors[min(number, len(colors) - 1)] if colors else None
            parts.append(LinkGeometry(geometry, pose @ local @ tilt, rgba=color))
            densities += numbers_of(collision, 'density', 1, (math.nan,))
            rubbing = self._friction(collision)
            contents.friction = rubbing if contents.friction is None else contents.friction
        contents.parts += parts
        if not contents.static:
            contents.add_inertial(self._inertial(link, pose, parts, densities),
                                  0.0 if flag_of(link, 'gravity', default=True) else 1.0)

    def _inertial(self, link: XmlElement, pose: Matrix, parts: Sequence[LinkGeometry],
                  densities: Sequence[float]) -> Inertial:
        """
        Return the mass properties of a link.

        :param densities: of its parts [kg/m^3]; NaN where a collision has none.
        """
        given, name = link.first('inertial'), link.get('name')
        try:
            volumes = [volume(part.geometry) for part in parts]
        except SimulationError as error:
            raise refused(link, f"link '{name}': {error}") from None
        if parts and not sum(volumes) > 0.0:
            raise refused(link, f"the shapes of link '{name}' enclose no volume")
        if given is not None and auto_of(given):
            if not parts:
                raise refused(given, f"link '{name}' has an automatic inertial and no <collision> "
                              'that is read')
            default = numbers_of(given, 'density', 1, (DEFAULT_DENSITY,))[0]
            masses = [positive(given, default if math.isnan(density) else density) * size
                      for size, density in zip(volumes, densities, strict=True)]
        elif given is not None:
            if given.first('mass') is not None and given.first('inertia') is None:
                self._unused.remarks.append(
                    f"{given.where}: link '{name}' has a mass and no <inertia>, "
                    'which SDF takes for 1 kg m^2 about each axis; give its own, or it hardly '
                    'turns')
            return _inertial(given, pose)
        elif not parts:
            return Inertial(DEFAULT_MASS, pose, inertial_of((), DEFAULT_MASS).inertia)
        else:
            masses = [DEFAULT_MASS * size / sum(volumes) for size in volumes]
        try:
            return solid_inertial(parts, masses)
        except SimulationError as error:
            raise refused(link, f"link '{name}': {error}") from None

    def _friction(self, collision: XmlElement) -> float | None:
        """Return the coefficient of friction of a shape, None where it has none."""
        surface = collision.first('surface')
        friction = surface.first('friction') if surface is not None else None
        for parent, read in ((surface, 'friction'), (friction, 'ode')):
            for child in parent.children if parent is not None else ():
                if child.tag != read:
                    self._unused.add(f"{named(child)} of collision '{collision.get('name')}'")
        ode = friction.first('ode') if friction is not None else None
        if ode is None or ode.first('mu') is None:
            return None
        return min(max(numbers_of(ode, 'mu', 1)[0], 0.0), 10.0)

    def _geometry(self, collision: XmlElement) -> tuple[Geometry | None, Matrix]:
        holder = collision.first('geometry')
        shape = holder.children[0] if holder is not None and holder.children else None
        if shape is None:
            raise refused(collision, f"collision '{collision.get('name')}' has no shape")
        if shape.tag == 'box':
            size = [positive(shape, number) for number in numbers_of(shape, 'size', 3)]
            return Box(triple(size)), np.eye(4)
        if shape.tag == 'sphere':
            return Sphere(positive(shape, *numbers_of(shape, 'radius', 1))), np.eye(4)
        if shape.tag in ('cylinder', 'capsule'):
            kind = Cylinder if shape.tag == 'cylinder' else Capsule
            radius, length = (numbers_of(shape, word, 1)[0] for word in ('radius', 'length'))
            return kind(positive(shape, radius), positive(shape, length)), np.eye(4)
        if shape.tag == 'plane':
            a, b, c = numbers_of(shape, 'normal', 3, (0.0, 0.0, 1.0))
            if not any((a, b, c)):
                raise refused(shape, 'the normal of a plane is 0')
            return Plane(a, b, c, 0.0), np.eye(4)
        if shape.tag == 'mesh':
            scale = triple(numbers_of(shape, 'scale', 3, (1.0, 1.0, 1.0)))
            return self.asset(self._read_mesh, text_of(shape, 'uri'), scale), np.eye(4)
        self._unused.add(f"shape <{shape.tag}> of collision '{collision.get('name')}'")
        return None, np.eye(4)


def _inertial(element: XmlElement, pose: Matrix) -> Inertial:
    mass = numbers_of(element, 'mass', 1, (DEFAULT_MASS,))[0]
    if not mass > 0.0:
        raise refused(element, f'the mass is {mass:g} kg; allowed: above 0')
    inertia = np.eye(3)
    table = element.first('inertia')
    if table is not None:
        xx, yy, zz, xy, xz, yz = (
            numbers_of(table, word, 1, (default,))[0]
            for word, default in (('ixx', 1.0), ('iyy', 1.0), ('izz', 1.0),
                                  ('ixy', 0.0), ('ixz', 0.0), ('iyz', 0.0)))
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Inertial(mass, pose @ _Scope().pose(element), inertia)
