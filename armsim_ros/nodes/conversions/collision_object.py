# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``moveit_msgs`` CollisionObject and AttachedCollisionObject to objects, and back."""

from __future__ import annotations

from collections.abc import Sequence

from geometry_msgs.msg import Pose
from moveit_msgs.msg import AttachedCollisionObject
from moveit_msgs.msg import CollisionObject as CollisionObjectMessage
import numpy as np
from shape_msgs.msg import Mesh as MeshMessage
from shape_msgs.msg import SolidPrimitive

from armsim_ros.arrays import Matrix
from armsim_ros.errors import PlanningError
from armsim_ros.model.geometry import Capsule, Geometry, Sphere
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.nodes.conversions.geometry import (
    mesh_from_message,
    plane_from_message,
    pose_from_message,
    pose_to_message,
    primitive_from_message,
    solid_to_message,
)
from armsim_ros.nodes.conversions.trajectory import trajectory_from_message, trajectory_to_message
from armsim_ros.planning.scene.objects import (
    AttachedObject,
    CollisionObject,
    object_error,
    ObjectOperation,
    ObjectShape,
    ObjectType,
)


def object_from_message(message: CollisionObjectMessage) -> CollisionObject:
    """
    Return an object, or what a message asks to do with it.

    :raises PlanningError: for a shape or pose that cannot exist, and for more poses than shapes.
    """
    try:
        return _object(message)
    except PlanningError as error:
        raise object_error(f"object '{message.id}': {error}") from None


def _object(message: CollisionObjectMessage) -> CollisionObject:
    operation = message.operation[0]
    shapes: tuple[tuple[Sequence[Geometry], Sequence[Pose]], ...] = (
        ([*map(primitive_from_message, message.primitives)], message.primitive_poses),
        ([*map(mesh_from_message, message.meshes)], message.mesh_poses),
        ([*map(plane_from_message, message.planes)], message.plane_poses))
    given = [(of_kind, tuple(map(pose_from_message, poses))) for of_kind, poses in shapes]
    moves = operation == ObjectOperation.MOVE
    made = operation in (ObjectOperation.ADD, ObjectOperation.APPEND)
    return CollisionObject(
        id=message.id,
        operation=operation,
        frame_id=message.header.frame_id,
        pose=pose_from_message(message.pose),
        shapes=tuple(
            shape for of_kind, poses in given if made for shape in _placed(of_kind, poses)),
        subframes={
            name: pose_from_message(pose)
            for name, pose in zip(message.subframe_names, message.subframe_poses, strict=False)},
        type=ObjectType(message.type.key, message.type.db),
        shape_poses=tuple(pose for _, poses in given for pose in poses) if moves else ())


def _placed(shapes: Sequence[Geometry], poses: Sequence[Matrix]) -> list[ObjectShape]:
    """Return shapes at their poses; those that are missing are the identity."""
    if len(poses) > len(shapes):
        raise object_error(
            f'{len(poses)} poses are given for {len(shapes)} shapes; at most one pose a shape is '
            'allowed')
    rest = (ObjectShape(shape) for shape in shapes[len(poses):])
    return [*map(ObjectShape, shapes, poses), *rest]


def attached_in_state_from_message(message: AttachedCollisionObject) -> AttachedObject:
    """
    Return what a request's start state asks to do with a carried object.

    :raises PlanningError: for a shape or pose that cannot exist, and where a shape has no pose.
    """
    item = message.object
    counts = [(len(item.primitives), len(item.primitive_poses)),
              (len(item.meshes), len(item.mesh_poses)), (len(item.planes), len(item.plane_poses))]
    if any(shapes != poses for shapes, poses in counts):
        raise object_error(
            f"attached object '{item.id}': a start state needs one pose for each primitive, mesh "
            'and plane')
    return attached_from_message(message)


def attached_from_message(message: AttachedCollisionObject) -> AttachedObject:
    """
    Return a carried object, or what a message asks to do with it.

    :raises PlanningError: for a shape or pose that cannot exist.
    """
    return AttachedObject(
        link_name=message.link_name, object=object_from_message(message.object),
        touch_links=tuple(message.touch_links),
        detach_posture=trajectory_from_message(message.detach_posture),
        weight=float(message.weight))


def object_to_message(
    item: CollisionObject, frame_id: str, *, geometry: bool = True
) -> CollisionObjectMessage:
    """
    Return the message that adds an object.

    :param frame_id: the frame of the object's pose.
    :param geometry: False for id and type only.
    """
    message = CollisionObjectMessage(id=item.id, operation=CollisionObjectMessage.ADD)
    message.header.frame_id = frame_id
    message.type.key, message.type.db = item.type.key, item.type.db
    if not geometry:
        return message
    message.pose = pose_to_message(item.pose)
    for shape in item.shapes:
        solid, pose = solid_to_message(shape.geometry), pose_to_message(shape.pose)
        if isinstance(solid, SolidPrimitive):
            message.primitives.append(solid)
            message.primitive_poses.append(pose)
        elif isinstance(solid, MeshMessage):
            message.meshes.append(solid)
            message.mesh_poses.append(pose)
        else:
            message.planes.append(solid)
            message.plane_poses.append(pose)
    message.subframe_names = list(item.subframes)
    message.subframe_poses = [
        pose_to_message(np.asarray(pose)) for pose in item.subframes.values()]
    return message


def world_object_to_message(
    item: WorldObject, pose: Matrix, frame_id: str
) -> CollisionObjectMessage:
    """
    Return the message that adds an object of the simulated world.

    A capsule, for which there is no message, becomes a cylinder and two balls.

    :param pose: (4, 4) in the frame.
    """
    shapes = []
    for part in item.parts:
        shapes.append(ObjectShape(part.geometry, part.origin))
        if isinstance(part.geometry, Capsule):
            ball, half = Sphere(part.geometry.radius), 0.5 * part.geometry.length
            shapes += [ObjectShape(ball, part.origin @ pose_matrix((0.0, 0.0, end)))
                       for end in (-half, half)]
    return object_to_message(CollisionObject(item.name, pose=pose, shapes=tuple(shapes)), frame_id)


def removal_message(object_id: str, frame_id: str) -> CollisionObjectMessage:
    """Return the message that removes an object."""
    message = CollisionObjectMessage(id=object_id, operation=CollisionObjectMessage.REMOVE)
    message.header.frame_id = frame_id
    return message


def attached_object_to_message(item: AttachedObject) -> AttachedCollisionObject:
    """Return the message of a carried object; its pose is relative to the link."""
    return AttachedCollisionObject(
        link_name=item.link_name, object=object_to_message(item.object, item.link_name),
        touch_links=sorted(item.touch_links),
        detach_posture=trajectory_to_message(item.detach_posture), weight=item.weight)
