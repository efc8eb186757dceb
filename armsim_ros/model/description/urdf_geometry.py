# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Shapes, poses and mass properties of URDF links."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.errors import ResourceError
from armsim_ros.model.description.xml_tree import (
    read_number,
    read_numbers,
    TextReport,
    XmlElement,
)
from armsim_ros.model.geometry import Box, Capsule, Cylinder, Geometry, Mesh, Sphere
from armsim_ros.model.robot_model import Inertial, LinkGeometry
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
    mass, inertia = element.first('mass'), element.first('inertia')
    if mass is None or inertia is None:
        missing = 'mass' if mass is None else 'inertia'
        report.error(f"<inertial> of link '{link.get('name')}' has no <{missing}>",
                     element.where)
        return None
    value = read_number(mass, 'value', report)
    parts = [read_number(inertia, key, report) for key in _INERTIA_KEYS]
    if value is None or any(part is None for part in parts):
        absent = [key for key in _INERTIA_KEYS if key not in inertia.attributes]
        if 'value' not in mass.attributes or absent:
            report.error(
                f"<inertial> of link '{link.get('name')}' is incomplete", element.where,
                'mass value, inertia ' + ' '.join(_INERTIA_KEYS))
        return None
    ixx, ixy, ixz, iyy, iyz, izz = (float(part or 0.0) for part in parts)
    matrix = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    return Inertial(value, read_origin(element, report), matrix)


def read_shapes(link: XmlElement, tag: str, materials: Mapping[str, Color],
                read_mesh: MeshReader, report: TextReport) -> tuple[LinkGeometry, ...]:
    """
    Return the shapes of a link.

    :param tag: ``collision`` or ``visual``.
    :param materials: name -> color of the robot's own materials.
    """
    shapes = []
    for element in link.all(tag):
        holder = element.first('geometry')
        if holder is None or not holder.children:
            report.error(f"<{tag}> of link '{link.get('name')}' has no <geometry> with a shape",
                         element.where)
            continue
        geometry = _read_geometry(holder.children[0], link.get('name'), tag, read_mesh, report)
        if geometry is not None:
            shapes.append(LinkGeometry(geometry, read_origin(element, report),
                                       element.get('name'), _color(element, materials, report)))
    return tuple(shapes)


def read_color(material: XmlElement, report: TextReport) -> Color | None:
    """Return the color that a ``<material>`` gives, None where it only names a material."""
    color = material.first('color')
    if color is None:
        return None
    r, g, b, a = read_numbers(color, 'rgba', 4, report, (0.5, 0.5, 0.5, 1.0))
    return r, g, b, a


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
            report.error(f"<{kind}> of link '{link}' needs radius and length", element.where)
            return None
        if not _positive(element, (pair[0], pair[1]), report):
            return None
        shape = Cylinder if kind == 'cylinder' else Capsule
        return shape(pair[0], pair[1])
    if kind == 'mesh':
        return _read_mesh(element, link, use, read_mesh, report)
    report.error(f"<{kind}> of link '{link}' is not a shape", element.where,
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
