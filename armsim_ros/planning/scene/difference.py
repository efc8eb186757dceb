# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Contents of scenes as messages: all of one, or what leads from one to the next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Mesh, Plane
from armsim_ros.planning.scene.attached_object import AttachedObject
from armsim_ros.planning.scene.content import SceneContent
from armsim_ros.planning.scene.update import (
    AttachedObjectUpdate,
    CollisionObjectUpdate,
    ObjectOperation,
    SceneUpdate,
    StartState,
)
from armsim_ros.planning.scene.world_object import CollisionObject

Value = TypeVar('Value')


def object_update(body: CollisionObject, frame_id: str) -> CollisionObjectUpdate:
    """Return the ADD that makes an object; ``frame_id`` is the frame of its pose."""
    primitives, meshes, planes = [], [], []
    for item in body.shapes:
        if isinstance(item.geometry, Mesh):
            meshes.append((item.geometry, item.pose))
        elif isinstance(item.geometry, Plane):
            planes.append((item.geometry, item.pose))
        else:
            primitives.append((item.geometry, item.pose))
    return CollisionObjectUpdate(
        body.id,
        ObjectOperation.ADD,
        frame_id,
        body.pose,
        tuple(geometry for geometry, _ in primitives),
        tuple(pose for _, pose in primitives),
        tuple(geometry for geometry, _ in meshes),
        tuple(pose for _, pose in meshes),
        tuple(geometry for geometry, _ in planes),
        tuple(pose for _, pose in planes),
        body.subframes,
        body.type,
    )


def attached_update(item: AttachedObject) -> AttachedObjectUpdate:
    """Return the ADD that attaches an object as it is."""
    return AttachedObjectUpdate(
        item.link_name,
        object_update(item.object, item.link_name),
        item.touch_links,
        item.detach_posture,
        item.weight,
    )


def full_update(kinematics: KinematicModel, content: SceneContent) -> SceneUpdate:
    """Return the message that makes a scene with this content from nothing."""
    frame = kinematics.robot.model_frame
    return SceneUpdate(
        is_diff=False,
        name=content.name,
        robot_state=StartState(
            kinematics.names,
            tuple(float(value) for value in content.q),
            is_diff=False,
            attached_objects=tuple(attached_update(item) for item in content.attached.values()),
        ),
        objects=tuple(object_update(body, frame) for body in content.objects.values()),
        acm=content.acm.to_update(),
        link_padding=content.link_padding,
        link_scale=content.link_scale,
        fixed_frames=content.frames,
        object_colors=content.colors,
    )


def scene_difference(
    kinematics: KinematicModel, before: SceneContent, after: SceneContent
) -> SceneUpdate:
    """
    Return the difference message that leads from one content to another.

    An object that went from the world to the robot is attached with its geometry; one that
    came back is detached and then added where it stands.
    """
    frame = kinematics.robot.model_frame
    moved = before.q is not after.q
    detached = tuple(
        AttachedObjectUpdate('', CollisionObjectUpdate(id_, ObjectOperation.REMOVE))
        for id_ in before.attached
        if id_ not in after.attached
    )
    attached = tuple(attached_update(item) for item in _renewed(before.attached, after.attached))
    gone = tuple(
        CollisionObjectUpdate(id_, ObjectOperation.REMOVE, frame)
        for id_ in [*before.objects, *(item.object.id for item in detached)]
        if id_ not in after.objects and id_ not in after.attached
    )
    came = tuple(
        object_update(body, frame)
        for body in after.objects.values()
        if before.objects.get(body.id) is not body
    )
    return SceneUpdate(
        is_diff=True,
        name=after.name,
        robot_state=StartState(
            kinematics.names if moved else (),
            tuple(float(value) for value in after.q) if moved else (),
            is_diff=True,
            attached_objects=detached + attached,
        ),
        objects=gone + came,
        acm=after.acm.to_update() if after.acm is not before.acm else None,
        link_padding=_changed(before.link_padding, after.link_padding),
        link_scale=_changed(before.link_scale, after.link_scale),
        fixed_frames=_changed(before.frames, after.frames),
        object_colors=_changed(before.colors, after.colors),
    )


def _changed(before: Mapping[str, Value], after: Mapping[str, Value]) -> Mapping[str, Value]:
    """Return the items that are new or another than before."""
    if before is after:
        return {}
    return {key: value for key, value in after.items() if before.get(key) is not value}


def _renewed(before: Mapping[str, Value], after: Mapping[str, Value]) -> list[Value]:
    if before is after:
        return []
    return [value for key, value in after.items() if before.get(key) is not value]
