# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the page sends to edit objects of the planning scene, and objects as text in a file."""

from __future__ import annotations

from typing import Any, Literal

from geometry_msgs.msg import Point, Pose
from moveit_msgs.msg import CollisionObject
from pydantic import Field
from shape_msgs.msg import Mesh, MeshTriangle, Plane, SolidPrimitive

from armsim_ros.nodes.web.page import PanelCommand

Three = tuple[float, float, float]
Four = tuple[float, float, float, float]


class Add(PanelCommand):
    """A new object before the robot."""

    shape: Literal['box', 'sphere', 'cylinder']


class AddMesh(PanelCommand):
    """A new object from a mesh file, its bytes in base64."""

    name: str = Field(max_length=200)
    data: str


class Change(PanelCommand):
    """Another place, turn (quaternion xyzw) or size of an object."""

    id: str
    xyz: Three | None = None
    turn: Four | None = None
    size: list[float] | None = Field(default=None, max_length=3)


class Named(PanelCommand):
    """An object."""

    id: str


class Select(PanelCommand):
    """The object to move by handles; '' for none."""

    id: str = ''


class Allow(PanelCommand):
    """Pairs that may touch from now on."""

    pairs: list[tuple[str, str]] = Field(min_length=1, max_length=50)


class Load(PanelCommand):
    """Objects that were saved."""

    text: str


class Save(PanelCommand):
    """The objects as text."""


def object_to_dict(message: CollisionObject) -> dict[str, Any]:
    """Return an object's name, frame, pose and shapes as plain values."""
    return {
        'id': message.id, 'frame': message.header.frame_id, 'pose': _listed(message.pose),
        'primitives': [
            {'type': int(shape.type), 'dimensions': list(shape.dimensions), 'pose': _listed(pose)}
            for shape, pose in zip(message.primitives, message.primitive_poses, strict=True)],
        'meshes': [
            {'vertices': [[p.x, p.y, p.z] for p in mesh.vertices],
             'triangles': [[int(i) for i in t.vertex_indices] for t in mesh.triangles],
             'pose': _listed(pose)}
            for mesh, pose in zip(message.meshes, message.mesh_poses, strict=True)],
        'planes': [
            {'coef': list(map(float, plane.coef)), 'pose': _listed(pose)}
            for plane, pose in zip(message.planes, message.plane_poses, strict=True)],
    }


def object_from_dict(values: dict[str, Any]) -> CollisionObject:
    """
    Return the object that was kept.

    :raises ValueError, KeyError, TypeError, AssertionError: the values are not those of a scene.
    """
    message = CollisionObject(id=str(values['id']), operation=CollisionObject.ADD)
    message.header.frame_id = str(values['frame'])
    message.pose = _pose(values['pose'])
    for each in values.get('primitives', ()):
        message.primitives.append(SolidPrimitive(
            type=int(each['type']), dimensions=list(map(float, each['dimensions']))))
        message.primitive_poses.append(_pose(each['pose']))
    for each in values.get('meshes', ()):
        message.meshes.append(Mesh(
            vertices=[Point(x=float(x), y=float(y), z=float(z)) for x, y, z in each['vertices']],
            triangles=[MeshTriangle(vertex_indices=list(map(int, row)))
                       for row in each['triangles']]))
        message.mesh_poses.append(_pose(each['pose']))
    for each in values.get('planes', ()):
        message.planes.append(Plane(coef=list(map(float, each['coef']))))
        message.plane_poses.append(_pose(each['pose']))
    return message


def _listed(pose: Pose) -> list[float]:
    point, turn = pose.position, pose.orientation
    return [point.x, point.y, point.z, turn.x, turn.y, turn.z, turn.w]


def _pose(numbers: list[float]) -> Pose:
    pose = Pose()
    point, turn = pose.position, pose.orientation
    (point.x, point.y, point.z, turn.x, turn.y, turn.z, turn.w) = map(float, numbers)
    return pose
