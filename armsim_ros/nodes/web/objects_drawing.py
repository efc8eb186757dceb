# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Objects in the scene: the planning scene's, and pale the simulation's that it does not know."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from moveit_msgs.msg import CollisionObject
import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.errors import ResourceError
from armsim_ros.model.geometry import Box, Cone, Cylinder, Geometry, Mesh, Plane, Sphere
from armsim_ros.model.transforms import pose_from_quat_xyzw, quat_wxyz_from_matrix
from armsim_ros.nodes.conversions.geometry import corners_from_message
from armsim_ros.nodes.web.shapes import Color, PLANE_SIZE, rgb, ShapeReader, Surface

#: What has no colour of its own: world objects, and attached ones.
WORLD_COLOR, ATTACHED_COLOR = (102, 178, 118), (176, 122, 214)
#: The page's own floor, and what is beyond, is seen through floors and walls.
_WALL_OPACITY = 0.2
_TOUCHED: Color = (214, 34, 34)
#: How much larger the red skin of a touched object is than the object.
_SKIN = 1.01
_KINDS = {1: 'box', 2: 'sphere', 3: 'cylinder', 4: 'cone'}


class DrawnObject:
    """
    An object.

    :param message: the CollisionObject.
    :param link: that it is attached to, '' for an object of the world.
    """

    def __init__(self, message: Any, link: str, rgba: Any) -> None:
        self.message, self.link = message, link
        self.frame = link or message.header.frame_id
        self.pose = pose_of(message.pose)
        if link and message.header.frame_id != link:
            self.frame = message.header.frame_id
        own = rgb((rgba.r, rgba.g, rgba.b)) if rgba is not None and rgba.a > 0.0 else None
        self.color: Color = own or (ATTACHED_COLOR if link else WORLD_COLOR)
        self.opacity = float(rgba.a) if rgba is not None and 0.0 < rgba.a < 1.0 else None
        if _is_wall(message):
            self.opacity = _WALL_OPACITY
        self.path = ''
        self.node: Any = None
        self.shapes: list[tuple[Surface, Matrix]] = []
        self.mark = (link, own, self.opacity, str(message))

    def form(self) -> dict[str, Any]:
        """Return what the panel has to know of it."""
        message = self.message
        kind = 'mesh' if message.meshes else 'plane' if message.planes else ''
        size: list[float] = []
        if len(message.primitives) == 1 and not kind:
            kind = _KINDS.get(message.primitives[0].type, 'shape')
            size = list(message.primitives[0].dimensions)
        elif message.primitives:
            kind = f'{len(message.primitives)} shapes'
        return {'id': message.id, 'kind': kind, 'size': size, 'frame': self.frame,
                'link': self.link, 'xyz': np.round(self.pose[:3, 3], 4).tolist(),
                'turn': [message.pose.orientation.x, message.pose.orientation.y,
                         message.pose.orientation.z, message.pose.orientation.w]}


class ObjectsDrawing:
    """
    All objects, each drawn anew where it has changed.

    :param node_of: frame -> path of its node.
    :param on_click: gets the object's name and the client that has clicked at it.
    """

    def __init__(self, scene: Any, reader: ShapeReader, node_of: Callable[[str], str],
                 on_click: Callable[[str, Any], None]) -> None:
        self._scene, self._reader = scene, reader
        self._node_of, self._on_click = node_of, on_click
        self.objects: dict[str, DrawnObject] = {}

    def show(self, objects: Mapping[str, DrawnObject]) -> None:
        """Draw these objects and no others."""
        for name, known in list(self.objects.items()):
            new = objects.get(name)
            if new is None or new.mark != known.mark or known.path != self._path(new):
                if known.node is not None:
                    known.node.remove()
                del self.objects[name]
        for name, new in objects.items():
            if name not in self.objects:
                self.objects[name] = new
                self._draw(name, new)

    def forget(self) -> None:
        """Note that everything in the scene is gone, or has moved."""
        for known in self.objects.values():
            if known.node is not None:
                known.node.remove()
        self.objects.clear()

    def highlight(self, scene: Any, names: set[str]) -> None:
        """Paint objects red in a session's scene, and all others as they are."""
        for name, known in self.objects.items():
            for index, (part, pose) in enumerate(known.shapes):
                scene.add_mesh_simple(
                    f'{known.path}/touched_{index}', part.vertices * _SKIN, part.faces,
                    color=_TOUCHED, opacity=0.6, visible=name in names, side='double',
                    position=pose[:3, 3], wxyz=quat_wxyz_from_matrix(pose))

    def _path(self, item: DrawnObject) -> str:
        return f'{self._node_of(item.frame)}/object_{item.message.id}'

    def _draw(self, name: str, item: DrawnObject) -> None:
        item.path = self._path(item)
        item.node = self._scene.add_frame(
            item.path, show_axes=False, position=item.pose[:3, 3],
            wxyz=quat_wxyz_from_matrix(item.pose))
        item.shapes = []
        for geometry, pose in geometries(item.message):
            try:
                parts = self._reader.parts(geometry)
            except ResourceError:
                continue
            for part in parts:
                item.shapes.append((part, pose))
                handle = self._scene.add_mesh_simple(
                    f'{item.path}/shape_{len(item.shapes)}', part.vertices, part.faces,
                    color=item.color, opacity=item.opacity, flat_shading=not part.smooth,
                    side='double', position=pose[:3, 3], wxyz=quat_wxyz_from_matrix(pose))
                handle.on_click(lambda event: self._on_click(name, event.client))


def _is_wall(message: Any) -> bool:
    """Return whether an object is a plane, or a box that is as wide as a plane is drawn."""
    return bool(message.planes) or any(
        shape.type == 1 and sorted((0.0, 0.0, *shape.dimensions))[-2] >= PLANE_SIZE
        for shape in message.primitives)


def geometries(message: Any) -> list[tuple[Geometry, Matrix]]:
    """Return the shapes of a CollisionObject and their poses (4, 4) in the object's frame."""
    found: list[tuple[Geometry, Matrix]] = []
    makers: dict[int, Callable[..., Geometry]] = {
        1: lambda x, y, z: Box((x, y, z)), 2: lambda r: Sphere(r),
        3: lambda h, r: Cylinder(r, h), 4: lambda h, r: Cone(r, h)}
    for shape, pose in zip(message.primitives, message.primitive_poses, strict=False):
        maker = makers.get(shape.type)
        if maker is not None:
            count = {1: 3, 2: 1}.get(shape.type, 2)
            found.append((maker(*shape.dimensions[:count]), pose_of(pose)))
    for mesh, pose in zip(message.meshes, message.mesh_poses, strict=False):
        if len(mesh.triangles) and len(mesh.vertices):
            found.append((Mesh(
                np.array([(p.x, p.y, p.z) for p in mesh.vertices]),
                np.array([t.vertex_indices for t in mesh.triangles], np.int64)), pose_of(pose)))
    for plane, pose in zip(message.planes, message.plane_poses, strict=False):
        found.append((Plane(*plane.coef), pose_of(pose)))
    return found


def pose_of(pose: Any) -> Matrix:
    """Return a pose message as a matrix (4, 4); a quaternion of zeros turns nothing."""
    point, turn = pose.position, pose.orientation
    quaternion = (turn.x, turn.y, turn.z, turn.w)
    if not any(quaternion):
        quaternion = (0.0, 0.0, 0.0, 1.0)
    return pose_from_quat_xyzw((point.x, point.y, point.z), quaternion)


def drawn_objects(scene: Any) -> dict[str, DrawnObject]:
    """Return the objects of a PlanningScene message, those of the world and attached ones."""
    colors = {entry.id: entry.color for entry in scene.object_colors}
    found = {item.id: DrawnObject(item, '', colors.get(item.id))
             for item in scene.world.collision_objects
             if item.operation != CollisionObject.REMOVE}
    for attached in scene.robot_state.attached_collision_objects:
        item = attached.object
        found[item.id] = DrawnObject(item, attached.link_name, colors.get(item.id))
    return found


_COLOR: Color = (150, 156, 166)
_OPACITY = 0.35
#: Of ``simulation_interfaces/msg/Bounds``.
_BOX = 1
#: What is thinner is drawn so thick [m].
_THINNEST = 1e-3


@dataclass(frozen=True, eq=False)
class Entity:
    """
    An object of the simulation.

    :param frame: of its pose.
    :param pose: the message.
    :param bounds: ``simulation_interfaces/msg/Bounds`` in its own frame, None for unknown ones.
    """

    name: str
    frame: str
    pose: Any
    bounds: Any

    def box(self) -> tuple[Matrix, Matrix] | None:
        """Return the middle and the sides of the box that it fills, (3,) each [m]."""
        if self.bounds is None or self.bounds.type != _BOX or len(self.bounds.points) != 2:
            return None
        low, high = corners_from_message(self.bounds.points)
        return 0.5 * (low + high), np.maximum(high - low, _THINNEST)

    def form(self) -> dict[str, Any]:
        """Return what the panel has to know of it."""
        position = self.pose.position
        return {'name': self.name, 'xyz': [round(getattr(position, axis), 3) for axis in 'xyz']}


class EntitiesDrawing:
    """
    Boxes, one per entity.

    :param node_of: frame -> path of its node.
    """

    def __init__(self, scene: Any, node_of: Callable[[str], str]) -> None:
        self._scene, self._node_of = scene, node_of
        self._nodes: dict[str, tuple[tuple[float, ...], Any]] = {}

    def show(self, entities: Sequence[Entity]) -> None:
        """Draw these and no others; what has not moved is not sent again."""
        boxes = {entity.name: (entity, box) for entity in entities
                 if (box := entity.box()) is not None}
        for name in set(self._nodes) - set(boxes):
            self._nodes.pop(name)[1].remove()
        for name, (entity, (middle, sides)) in boxes.items():
            pose = pose_of(entity.pose)
            pose[:3, 3] += pose[:3, :3] @ middle
            path = f'{self._node_of(entity.frame)}/entity_{name}'
            mark = (path, *sides.tolist())
            known = self._nodes.get(name)
            if known is None or known[0] != mark:
                if known is not None:
                    known[1].remove()
                node = self._scene.add_box(
                    path, color=_COLOR, dimensions=tuple(sides.tolist()), opacity=_OPACITY,
                    cast_shadow=False)
                known = self._nodes[name] = (mark, node)
            _put(known[1], pose)


def _put(node: Any, pose: Matrix) -> None:
    position, turn = pose[:3, 3], quat_wxyz_from_matrix(pose)
    if not np.allclose(node.position, position, atol=1e-5):
        node.position = position
    if not np.allclose(node.wxyz, turn, atol=1e-5):
        node.wxyz = turn
