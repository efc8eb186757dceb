# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Elements of a URDF: shapes, poses, mass properties, joints and transmissions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
import math

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.errors import nearest, ResourceError
from armsim_ros.model.description.xml_tree import read_number, read_numbers, TextReport, XmlElement
from armsim_ros.model.geometry import Box, Capsule, Cylinder, Geometry, Mesh, Sphere
from armsim_ros.model.robot_model import (
    Inertial,
    Joint,
    JointLimits,
    JointType,
    LinkGeometry,
    Mimic,
    SoftLimits,
)
from armsim_ros.model.transforms import pose_matrix

Scale = tuple[float, float, float]
#: Reads a mesh by its address and scale; None leaves the shape out.
MeshReader = Callable[[str, Scale], Mesh | None]
Color = tuple[float, float, float, float]

_INERTIA_KEYS = ('ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz')


def read_origin(element: XmlElement, report: TextReport) -> Matrix:
    """Return the pose (4, 4) of an element's ``<origin>``; identity by default."""
    origin = element.first('origin')
    if origin is None:
        return np.eye(4)
    xyz = read_numbers(origin, 'xyz', 3, report, (0.0, 0.0, 0.0))
    rpy = read_numbers(origin, 'rpy', 3, report, (0.0, 0.0, 0.0))
    return pose_matrix(xyz, rpy)


def read_inertial(link: XmlElement, report: TextReport) -> Inertial | None:
    """Return a link's mass properties as written; None where it has none, or not all."""
    element = link.first('inertial')
    if element is None:
        return None
    part = TextReport()
    values: list[float] = []
    for tag, keys in (('mass', ('value',)), ('inertia', _INERTIA_KEYS)):
        holder = element.first(tag)
        absent = [key for key in keys if holder is None or key not in holder.attributes]
        if holder is None or absent:
            part.error(f'<inertial> has no <{tag} {" ".join(absent)}>', element.where)
        else:
            values += [read_number(holder, key, part, 0.0) or 0.0 for key in keys]
    origin = read_origin(element, part)
    if report.without(part, f"<inertial> of link '{link.get('name')}'"):
        return None
    mass, ixx, ixy, ixz, iyy, iyz, izz = values
    matrix = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    return Inertial(mass, origin, matrix)


def read_shapes(link: XmlElement, tag: str, materials: Mapping[str, Color],
                read_mesh: MeshReader, report: TextReport) -> tuple[LinkGeometry, ...]:
    """
    Return the shapes of a link; one with an error is left out.

    :param tag: ``collision`` or ``visual``.
    :param materials: name -> color of the robot's own materials.
    """
    shapes = []
    for element in link.all(tag):
        part = TextReport()
        geometry: Geometry | None = None
        origin, color = read_origin(element, part), _color(element, materials, part)
        holder = element.first('geometry')
        if holder is None or not holder.children:
            part.error(f'<{tag}> has no <geometry> with a shape', element.where)
        else:
            geometry = _read_geometry(
                holder.children[0], link.get('name'), tag, read_mesh, part)
        left_out = report.without(part, f"<{tag}> of link '{link.get('name')}'")
        if geometry is not None and not left_out:
            shapes.append(LinkGeometry(geometry, origin, element.get('name'), color))
    return tuple(shapes)


def read_color(material: XmlElement, report: TextReport) -> Color | None:
    """Return the color that a ``<material>`` gives, None where it only names a material."""
    color = material.first('color')
    if color is None:
        return None
    part = TextReport()
    r, g, b, a = read_numbers(color, 'rgba', 4, part, (0.5, 0.5, 0.5, 1.0))
    return None if report.without(part, f"color of material '{material.get('name')}'") else (
        r, g, b, a)


def _color(element: XmlElement, materials: Mapping[str, Color], report: TextReport
           ) -> Color | None:
    material = element.first('material')
    if material is None:
        return None
    return read_color(material, report) or materials.get(material.get('name'))


def _read_geometry(element: XmlElement, link: str, use: str, read_mesh: MeshReader,
                   report: TextReport) -> Geometry | None:
    kind = element.tag
    if kind == 'box':
        size = read_numbers(element, 'size', 3, report, ())
        if size and min(size) == 0.0 and max(size) > 0.0:
            # Drawn as a plane, by Gazebo's users; it has no inside to be in.
            report.ignored(f"link '{link}' has no {use} geometry of a box without volume",
                           element.where)
            return None
        return Box((size[0], size[1], size[2])) if _positive(element, size, report) else None
    if kind == 'sphere':
        radius = read_number(element, 'radius', report)
        return Sphere(radius) if radius and _positive(element, (radius,), report) else None
    if kind in ('cylinder', 'capsule'):
        pair = (read_number(element, 'radius', report), read_number(element, 'length', report))
        if pair[0] is None or pair[1] is None:
            report.error(f'<{kind}> needs radius and length', element.where)
            return None
        if not _positive(element, (pair[0], pair[1]), report):
            return None
        shape = Cylinder if kind == 'cylinder' else Capsule
        return shape(pair[0], pair[1])
    if kind == 'mesh':
        return _read_mesh(element, link, use, read_mesh, report)
    report.error(f'<{kind}> is not a shape', element.where,
                 'box, sphere, cylinder, capsule, mesh')
    return None


def _positive(element: XmlElement, values: tuple[float, ...], report: TextReport) -> bool:
    if values and all(value > 0.0 for value in values):
        return True
    if values or not element.attributes:
        report.error(f'<{element.tag}> needs sizes above 0', element.where)
    return False


def _read_mesh(element: XmlElement, link: str, use: str, read_mesh: MeshReader,
               report: TextReport) -> Mesh | None:
    uri = element.get('filename')
    if not uri:
        report.error("<mesh> has no 'filename'", element.where)
        return None
    scale = read_numbers(element, 'scale', 3, report, (1.0, 1.0, 1.0))
    try:
        return read_mesh(uri, (scale[0], scale[1], scale[2]))
    except ResourceError as error:
        if use == 'visual':
            report.info(f"link '{link}' is not shown: {error}", element.where)
        else:
            report.ignored(f"link '{link}' has no collision geometry: {error}", element.where)
        return None


_TYPES = tuple(kind.value for kind in JointType)
_BOUNDED = (JointType.REVOLUTE, JointType.PRISMATIC)
_WITH_AXIS = (*_BOUNDED, JointType.CONTINUOUS, JointType.PLANAR)


@dataclass(frozen=True, slots=True)
class Transmission:
    """
    A URDF's data on a joint's motor.

    :param interfaces: the hardware interfaces, 'position', 'velocity' or 'effort'.
    :param reduction: gear ratio; noted, the simulated joints have no gears.
    """

    name: str
    joint: str
    interfaces: tuple[str, ...]
    reduction: float = 1.0


def read_joint(element: XmlElement, report: TextReport) -> Joint | None:
    """Return a joint, None where its name, type or links are wrong; errors are reported."""
    name = element.get('name')
    if not name:
        report.error('<joint> has no name', element.where)
        return None
    kind = element.get('type')
    if kind not in _TYPES:
        report.error(f"joint '{name}' has the type '{kind}'", element.where, ', '.join(_TYPES),
                     nearest(kind, _TYPES))
        return None
    ends = [_linked(element, end, report) for end in ('parent', 'child')]
    if not all(ends):
        return None
    joint_type = JointType(kind)
    dynamics = element.first('dynamics')
    return Joint(
        name, joint_type, ends[0], ends[1], read_origin(element, report),
        _axis(element, joint_type, report), _limits(element, joint_type, report),
        _mimic(element, report),
        *((0.0, 0.0) if dynamics is None else _dynamics(name, dynamics, report)),
        soft_limits=_soft_limits(element, report))


def read_transmissions(robot: XmlElement, report: TextReport) -> tuple[Transmission, ...]:
    """Return what the URDF's ``<transmission>`` elements declare, an entry per joint."""
    found = []
    for element in robot.all('transmission'):
        reductions = [part for holder in element.children if holder.tag in ('actuator', 'joint')
                      for part in holder.all('mechanicalReduction')]
        reduction = _reduction(reductions, report)
        for joint in element.all('joint'):
            interfaces = []
            for part in joint.all('hardwareInterface'):
                word = part.content.rsplit('/', 1)[-1]
                kind = word.removesuffix('JointInterface').lower()
                if kind in ('position', 'velocity', 'effort', 'posvel', 'posvelacc'):
                    interfaces.append(kind)
                else:
                    report.warning(
                        f"hardware interface '{part.content}' of joint '{joint.get('name')}' is "
                        'not known and has no effect', part.where)
            found.append(Transmission(element.get('name'), joint.get('name'),
                                      tuple(interfaces), reduction))
    return tuple(found)


def _reduction(elements: list[XmlElement], report: TextReport) -> float:
    for element in elements:
        try:
            value = float(element.content)
        except ValueError:
            value = math.nan
        if math.isfinite(value) and value != 0.0:
            return value
        report.warning(f"mechanicalReduction '{element.content}' is not a number other than 0; "
                       'it has no effect', element.where)
    return 1.0


def _linked(element: XmlElement, end: str, report: TextReport) -> str:
    holder = element.first(end)
    link = holder.get('link') if holder is not None else ''
    if not link:
        report.error(f"joint '{element.get('name')}' has no <{end} link=...>", element.where)
    return link


def _axis(element: XmlElement, kind: JointType, report: TextReport) -> Matrix:
    holder = element.first('axis')
    given = (1.0, 0.0, 0.0) if holder is None else read_numbers(
        holder, 'xyz', 3, report, (1.0, 0.0, 0.0))
    axis = np.array(given, dtype=np.float64)
    length = float(np.linalg.norm(axis))
    if length < 1e-9:
        if kind in _WITH_AXIS:
            report.error(f"the axis of joint '{element.get('name')}' has length 0",
                         (holder or element).where)
        return np.array([1.0, 0.0, 0.0])
    return axis / length


def _limits(element: XmlElement, kind: JointType, report: TextReport) -> JointLimits:
    name, holder = element.get('name'), element.first('limit')
    if holder is None:
        if kind in _BOUNDED:
            report.error(
                f"joint '{name}' is {kind.value} and has no <limit>", element.where,
                remedy='add <limit lower=... upper=... effort=... velocity=.../>, or make it '
                       'continuous')
        return JointLimits()
    if kind in _BOUNDED:
        for key in ('effort', 'velocity'):
            if key not in holder.attributes:
                report.error(f"<limit> of joint '{name}' has no '{key}'", holder.where)
    lower, upper = -math.inf, math.inf
    if kind in _BOUNDED:
        lower = read_number(holder, 'lower', report, 0.0) or 0.0
        upper = read_number(holder, 'upper', report, 0.0) or 0.0
        if lower > upper:
            report.ignored(f"joint '{name}' has lower {lower:g} above upper {upper:g}; they are "
                           'exchanged', holder.where, 'correct its <limit>')
            lower, upper = upper, lower
        elif lower == upper:
            report.warning(f"joint '{name}' cannot move: lower and upper are both {lower:g}",
                           holder.where, 'give it a range, or make it fixed')
    velocity, effort = (_bound(holder, key, name, report) for key in ('velocity', 'effort'))
    zeros = [key for key, value in (('velocity', velocity), ('effort', effort)) if value == 0.0]
    if zeros:
        report.warning(
            f"joint '{name}': limit 0 of {' and '.join(zeros)} allows no motion; it is taken as "
            'no limit', holder.where, 'give the real value')
    return JointLimits(lower, upper, velocity or math.inf, effort=effort or math.inf)


def _bound(holder: XmlElement, key: str, joint: str, report: TextReport) -> float:
    """Return a bound's absolute value; exporters write 0 for an unknown bound."""
    value = read_number(holder, key, report)
    if value is None:
        return math.inf
    if value < 0.0:
        report.ignored(f"{key} limit of joint '{joint}' is {value:g}; {-value:g} is taken",
                       holder.where, 'give a number above 0')
    return abs(value)


def _soft_limits(element: XmlElement, report: TextReport) -> SoftLimits | None:
    holder = element.first('safety_controller')
    if holder is None:
        return None
    if 'k_velocity' not in holder.attributes:
        report.error(f"<safety_controller> of joint '{element.get('name')}' has no 'k_velocity'",
                     holder.where)
    return SoftLimits(*(
        read_number(holder, key, report, 0.0) or 0.0
        for key in ('soft_lower_limit', 'soft_upper_limit', 'k_position', 'k_velocity')))


def _mimic(element: XmlElement, report: TextReport) -> Mimic | None:
    holder = element.first('mimic')
    if holder is None:
        return None
    joint = holder.get('joint')
    if not joint:
        report.error(f"<mimic> of joint '{element.get('name')}' names no joint", holder.where)
        return None
    multiplier = read_number(holder, 'multiplier', report, 1.0)
    offset = read_number(holder, 'offset', report, 0.0)
    return Mimic(joint, 1.0 if multiplier is None else multiplier, offset or 0.0)


def _dynamics(joint: str, holder: XmlElement, report: TextReport) -> tuple[float, float]:
    """Return damping and friction."""
    values = []
    for key in ('damping', 'friction'):
        value = read_number(holder, key, report, 0.0) or 0.0
        if value < 0.0:
            report.ignored(f"{key} of joint '{joint}' is {value:g}; it is taken as 0",
                           holder.where, 'give a number not below 0')
        values.append(max(value, 0.0))
    return values[0], values[1]
