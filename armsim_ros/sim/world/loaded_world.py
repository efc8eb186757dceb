# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a file or text of a world gave, or why it gave nothing; objects of a shape or a URDF."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
import math
from urllib.parse import parse_qsl

import numpy as np
from pydantic import ValidationError

from armsim_ros.arrays import Matrix
from armsim_ros.config.world import WorldObjectSettings
from armsim_ros.errors import ModelError, nearest, SimulationError
from armsim_ros.model.description.urdf import parse_urdf
from armsim_ros.model.description.xml_tree import parse_xml, XmlElement
from armsim_ros.model.geometry import Mesh
from armsim_ros.model.inertia import combined, inertial_of
from armsim_ros.model.robot_model import Inertial, JointType, LinkGeometry
from armsim_ros.model.world_objects import object_from_settings, WorldObject


class Fault(Enum):
    """Why a resource cannot be used; the names of simulation_interfaces' result codes."""

    UNSUPPORTED_FORMAT = 'unsupported format'
    NO_RESOURCE = 'no resource'
    RESOURCE_PARSE_ERROR = 'parse error'
    MISSING_ASSETS = 'missing assets'
    UNSUPPORTED_ASSETS = 'unsupported assets'


#: Faults of files that a world refers to.
ASSET_FAULTS = (Fault.MISSING_ASSETS, Fault.UNSUPPORTED_ASSETS)


class ResourceFaultError(SimulationError):
    """
    A file or text of a world cannot be used.

    :param fault: the kind of error.
    :param text: what is wrong, where, and what is allowed.
    """

    def __init__(self, fault: Fault, text: str) -> None:
        super().__init__(text)
        self.fault = fault


class Unused:
    """
    Collects what of a file has no effect here, each once.

    :ivar remarks: what the file leaves to a default, with its place.
    """

    def __init__(self) -> None:
        self._lines: dict[str, None] = {}
        self.remarks: list[str] = []

    def add(self, line: str) -> None:
        """Note an element."""
        self._lines[line] = None

    @property
    def lines(self) -> tuple[str, ...]:
        """All of them, in the order in which they were found."""
        return tuple(self._lines)


@dataclass(frozen=True, slots=True, eq=False)
class LoadedObject:
    """
    An object that was read.

    :param item: the object; its pose is that of the file.
    :param unused: what of the file has no effect here, a line each.
    :param remarks: what the file leaves to a default, a line each.
    """

    item: WorldObject
    unused: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class LoadedWorld:
    """
    A world that was read.

    :param floor: height of the floor [m]; None where there is none.
    :param unused: what of the file has no effect here, a line each.
    :param gravity: [m/s^2]; None where ``simulation.yaml`` decides.
    :param remarks: what the file leaves to a default, a line each.
    """

    name: str
    items: tuple[WorldObject, ...]
    floor: float | None = None
    unused: tuple[str, ...] = ()
    gravity: tuple[float, float, float] | None = None
    remarks: tuple[str, ...] = ()


def told_of(loaded: LoadedObject | LoadedWorld) -> str:
    """Return what a user should know of what was read, '' for nothing."""
    unused = (f'not used: {"; ".join(loaded.unused)}',) if loaded.unused else ()
    return '; '.join((*unused, *loaded.remarks))


def parse(text: str, file: str) -> XmlElement:
    """
    Return the root element of a text.

    :raises ResourceFaultError: it is not XML; with its line.
    """
    try:
        return parse_xml(text, file)
    except ModelError as error:
        raise ResourceFaultError(Fault.RESOURCE_PARSE_ERROR, str(error)) from None


def check_names(items: Iterable[WorldObject]) -> None:
    """
    Refuse a world with two objects of the same name.

    :raises ResourceFaultError: names it.
    """
    seen: set[str] = set()
    for item in items:
        if item.name in seen:
            raise ResourceFaultError(
                Fault.RESOURCE_PARSE_ERROR, f"two objects have the name '{item.name}'")
        seen.add(item.name)


#: Shape -> its measures, with the count of numbers and what they are where not given.
MEASURES: Mapping[str, Mapping[str, tuple[int, str]]] = {
    'box': {'size': (3, '0.1,0.1,0.1')},
    'sphere': {'radius': (1, '0.05')},
    'cylinder': {'radius': (1, '0.05'), 'length': (1, '0.1')},
    'capsule': {'radius': (1, '0.05'), 'length': (1, '0.1')},
    'cone': {'radius': (1, '0.05'), 'length': (1, '0.1')},
}
#: What every shape may have; without a mass it never moves.
_COMMON = {'mass': 1, 'friction': 1, 'color': 0}


def shape_object(shape: str, query: str) -> LoadedObject:
    """
    Return the object that an address describes; it has no name.

    :param shape: such as ``box``.
    :param query: what follows the question mark.
    :raises ResourceFaultError: names the word that is wrong and what is allowed.
    """
    measures = MEASURES[shape]
    known = (*measures, *_COMMON)
    words = dict(parse_qsl(query, keep_blank_values=True))
    for word in words:
        if word not in known:
            hint = nearest(word, known) or f'allowed: {", ".join(known)}'
            raise _refused(f"'{word}' is not a word of armsim://{shape}; {hint}")
    content: dict[str, object] = {'type': shape}
    for word, (count, default) in measures.items():
        numbers = _numbers(word, words.get(word, default), count)
        content[word] = numbers if count > 1 else numbers[0]
    settings: dict[str, object] = {'parts': [{'shape': content}]}
    for word in ('mass', 'friction'):
        if word in words:
            settings[word] = _numbers(word, words[word], 1)[0]
    if 'color' in words:
        color = _numbers('color', words['color'], 0)
        settings['color'] = [*color, 1.0] if len(color) == 3 else color
    try:
        checked = WorldObjectSettings.model_validate(settings)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = '.'.join(str(key) for key in first['loc'])
        raise _refused(f"armsim://{shape}: {place}: {first['msg']}") from None
    return LoadedObject(object_from_settings('', checked))


def _numbers(word: str, text: str, count: int) -> list[float]:
    try:
        values = [float(part) for part in text.split(',')]
    except ValueError:
        values = []
    if not values or not all(map(math.isfinite, values)) or (count and len(values) != count):
        requested = f'{count} finite numbers' if count > 1 else 'a finite number'
        raise _refused(f'{word}={text[:60]} is wrong; allowed: {requested}, parted by commas')
    return values


def _refused(text: str) -> ResourceFaultError:
    return ResourceFaultError(Fault.RESOURCE_PARSE_ERROR, text)


MeshReader = Callable[[str, tuple[float, float, float]], Mesh]

#: The root link of a URDF that is fixed to the world, and the words by which ``<static>`` is true;
#: as sdformat's parser_urdf.cc has them.
_WORLD_LINK, _YES = 'world', ('true', 'yes', '1')


def urdf_object(text: str, file: str, read_mesh: MeshReader) -> LoadedObject:
    """
    Return a URDF as an object; its joints are fixed at 0.

    It moves freely unless its root link is ``world`` or a ``<gazebo>`` has ``<static>``.

    :raises ResourceFaultError: the text is wrong; with its line.
    """
    try:
        content = parse_urdf(text, file, read_mesh=read_mesh)
    except ModelError as error:
        raise ResourceFaultError(Fault.RESOURCE_PARSE_ERROR, str(error)) from None
    unused = Unused()
    for problem in content.problems:
        unused.add(str(problem))
    poses: dict[str, Matrix] = {content.root_link: np.eye(4)}
    for joint in content.joints.values():
        poses[joint.child] = poses[joint.parent] @ joint.origin
        if joint.type is not JointType.FIXED:
            unused.add(f"joint '{joint.name}' of type '{joint.type.value}': its links hold "
                       'together')
    parts: list[LinkGeometry] = []
    inertials: list[Inertial] = []
    for name, link in content.links.items():
        color = next((shape.rgba for shape in link.visuals if shape.rgba), None)
        parts += [LinkGeometry(shape.geometry, poses[name] @ shape.origin,
                               rgba=shape.rgba or color) for shape in link.collisions]
        if link.inertial is not None:
            inertials.append(Inertial(link.inertial.mass, poses[name] @ link.inertial.origin,
                                      link.inertial.inertia))
    if not parts:
        raise ResourceFaultError(
            Fault.RESOURCE_PARSE_ERROR, f"{file}: '{content.name}' has no <collision>")
    held = content.root_link == _WORLD_LINK and any(
        joint.parent == _WORLD_LINK and joint.type is not JointType.FLOATING
        for joint in content.joints.values())
    if held or _is_static(parse(text, file)):
        return LoadedObject(WorldObject(content.name, np.eye(4), tuple(parts)), unused.lines)
    whole = combined(inertials) if inertials else inertial_of(parts)
    item = WorldObject(content.name, np.eye(4), tuple(parts), whole.mass, inertial=whole)
    return LoadedObject(item, unused.lines)


def _is_static(robot: XmlElement) -> bool:
    """Return whether a ``<gazebo>`` of a URDF has it never move; the last word counts."""
    words = [element.content.lower() for gazebo in robot.all('gazebo')
             if not gazebo.get('reference') for element in gazebo.all('static')]
    return bool(words) and words[-1] in _YES
