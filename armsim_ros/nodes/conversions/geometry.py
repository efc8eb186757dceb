# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``geometry_msgs`` and ``shape_msgs``: poses as (4, 4) matrices, shapes as geometry."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

from geometry_msgs.msg import Point, Pose, Quaternion, Transform, Vector3
import numpy as np
from shape_msgs.msg import Mesh as MeshMessage
from shape_msgs.msg import MeshTriangle, SolidPrimitive
from shape_msgs.msg import Plane as PlaneMessage

from armsim_ros.arrays import Matrix
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.model.geometry import (
    Box,
    Capsule,
    Cone,
    Cylinder,
    Geometry,
    Mesh,
    Plane,
    shape_fault,
    Sphere,
)
from armsim_ros.model.transforms import quat_xyzw_from_matrix
from armsim_ros.planning.scene.objects import message_pose

Shape = TypeVar('Shape', bound=Geometry)

_DIMENSIONS = {
    SolidPrimitive.BOX: ('BOX', 3),
    SolidPrimitive.SPHERE: ('SPHERE', 1),
    SolidPrimitive.CYLINDER: ('CYLINDER', 2),
    SolidPrimitive.CONE: ('CONE', 2),
}


def pose_from_message(message: Pose) -> Matrix:
    """
    Return a pose (4, 4); an all-zero quaternion is read as identity.

    :raises PlanningError: for numbers that are not a pose.
    """
    position, orientation = message.position, message.orientation
    return message_pose(
        (position.x, position.y, position.z),
        (orientation.x, orientation.y, orientation.z, orientation.w))


def pose_from_transform(message: Transform) -> Matrix:
    """Return the pose (4, 4) of a transform message."""
    translation, rotation = message.translation, message.rotation
    return message_pose(
        (translation.x, translation.y, translation.z),
        (rotation.x, rotation.y, rotation.z, rotation.w))


def pose_to_message(pose: Matrix) -> Pose:
    """Return the message of a pose (4, 4)."""
    x, y, z, w = (float(value) for value in quat_xyzw_from_matrix(pose))
    message = Pose(orientation=Quaternion(x=x, y=y, z=z, w=w))
    message.position = Point(x=float(pose[0, 3]), y=float(pose[1, 3]), z=float(pose[2, 3]))
    return message


def corners_from_message(points: Sequence[Vector3]) -> tuple[Matrix, Matrix]:
    """
    Return the smallest and the largest corner (3,) of an axis-aligned box [m].

    :param points: two opposite corners, in any order, such as those of
        ``simulation_interfaces/msg/Bounds``.
    """
    corners = [(point.x, point.y, point.z) for point in points]
    return np.min(corners, axis=0), np.max(corners, axis=0)


def primitive_from_message(message: SolidPrimitive) -> Geometry:
    """
    Return the shape of a primitive; dimensions that it does not need are ignored.

    :raises PlanningError: for an unknown type, missing or impossible dimensions.
    """
    missing = missing_primitive(message)
    if missing:
        raise _refused(missing)
    sizes = [float(value) for value in message.dimensions]
    if message.type == SolidPrimitive.BOX:
        return _usable(Box((sizes[0], sizes[1], sizes[2])))
    if message.type == SolidPrimitive.SPHERE:
        return _usable(Sphere(sizes[0]))
    kind = Cylinder if message.type == SolidPrimitive.CYLINDER else Cone
    return _usable(kind(radius=sizes[1], length=sizes[0]))


def missing_primitive(message: SolidPrimitive) -> str:
    """Return why a message describes no primitive: its type or number of dimensions; or ''."""
    if message.type not in _DIMENSIONS:
        known = ', '.join(f'{name} ({number})' for number, (name, _) in _DIMENSIONS.items())
        return f'primitive type {message.type} is not supported; allowed: {known}'
    name, count = _DIMENSIONS[message.type]
    given = len(message.dimensions)
    return '' if given >= count else f'a {name} needs {count} dimensions, {given} were given'


def mesh_from_message(message: MeshMessage) -> Mesh:
    """
    Return the triangles of a mesh.

    :raises PlanningError: no triangles, indices outside the vertices, or no numbers.
    """
    vertices = np.array([(v.x, v.y, v.z) for v in message.vertices], dtype=np.float64)
    triangles = np.array([t.vertex_indices for t in message.triangles], dtype=np.int64)
    return _usable(Mesh(vertices.reshape(-1, 3), triangles.reshape(-1, 3)))


def plane_from_message(message: PlaneMessage) -> Plane:
    """
    Return the plane of a message.

    :raises PlanningError: its normal has no direction.
    """
    a, b, c, d = (float(value) for value in message.coef)
    return _usable(Plane(a, b, c, d))


def solid_to_message(geometry: Geometry) -> SolidPrimitive | MeshMessage | PlaneMessage:
    """Return the message of a shape; a capsule, which has none, becomes its cylinder."""
    if isinstance(geometry, Box):
        return SolidPrimitive(type=SolidPrimitive.BOX, dimensions=list(geometry.size))
    if isinstance(geometry, Sphere):
        return SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[geometry.radius])
    if isinstance(geometry, (Cylinder, Capsule)):
        return SolidPrimitive(
            type=SolidPrimitive.CYLINDER, dimensions=[geometry.length, geometry.radius])
    if isinstance(geometry, Cone):
        return SolidPrimitive(
            type=SolidPrimitive.CONE, dimensions=[geometry.length, geometry.radius])
    if isinstance(geometry, Plane):
        return PlaneMessage(coef=[geometry.a, geometry.b, geometry.c, geometry.d])
    return MeshMessage(
        vertices=points_to_messages(geometry.vertices),
        triangles=[
            MeshTriangle(vertex_indices=np.asarray(row, dtype=np.uint32))
            for row in geometry.triangles])


def points_to_messages(points: Matrix | Sequence[Sequence[float]]) -> list[Point]:
    """Return points (n, 3) [m] as messages."""
    return [Point(x=float(x), y=float(y), z=float(z)) for x, y, z in points]


def _usable(shape: Shape) -> Shape:
    fault = shape_fault(shape)
    if fault:
        raise _refused(fault)
    return shape


def _refused(text: str) -> PlanningError:
    return PlanningError(MoveItErrorCode.INVALID_OBJECT_NAME, text, 'shape')
