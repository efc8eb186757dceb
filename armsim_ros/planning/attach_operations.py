# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Taking objects from the world onto the robot and back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from armsim_ros.errors import nearest, PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.transforms import inverse_pose
from armsim_ros.planning.attached_object import AttachedObject
from armsim_ros.planning.error_codes import MoveItErrorCode
from armsim_ros.planning.object_checks import object_error
from armsim_ros.planning.object_operations import (
    build_object,
    check_id,
    given_pose,
    known_operation,
    merged,
)
from armsim_ros.planning.scene_content import SceneContent, with_item, without_items
from armsim_ros.planning.scene_update import AttachedObjectUpdate, ObjectOperation
from armsim_ros.planning.world_object import CollisionObject

Matrix = NDArray[np.float64]


def apply_attached(
    kinematics: KinematicModel, content: SceneContent, update: AttachedObjectUpdate
) -> SceneContent:
    """
    Return the content after one operation on an attached object.

    :raises PlanningError: INVALID_OBJECT_NAME, INVALID_LINK_NAME or FRAME_TRANSFORM_FAILURE.
    """
    operation = known_operation(update.object)
    if operation is ObjectOperation.REMOVE:
        return _detach(kinematics, content, update)
    check_id(update.object.id)
    if operation is ObjectOperation.MOVE:
        raise object_error(
            f"attached object '{update.object.id}' cannot be moved on its link; detach it, "
            'or attach it again with another pose'
        )
    _check_link(kinematics, update.link_name, update.object.id)
    if operation is ObjectOperation.APPEND and update.object.id in content.attached:
        return _append(kinematics, content, update)
    return _attach(kinematics, content, update)


def _check_link(kinematics: KinematicModel, link: str, id_: str) -> None:
    if not kinematics.has_link(link):
        known = tuple(kinematics.robot.links)
        raise PlanningError(
            MoveItErrorCode.INVALID_LINK_NAME,
            f"object '{id_}' cannot be attached to link '{link}', which robot "
            f"'{kinematics.robot.name}' does not have {nearest(link, known)}".rstrip(),
            'planning scene',
        )


def _attach(
    kinematics: KinematicModel, content: SceneContent, update: AttachedObjectUpdate
) -> SceneContent:
    body = _body(kinematics, content, update)
    pose_of_link = kinematics.link_pose(content.q, update.link_name)
    return _with_attached(
        content,
        AttachedObject(
            body.at(inverse_pose(pose_of_link) @ body.pose),
            update.link_name,
            tuple(dict.fromkeys(update.touch_links)),
            update.detach_posture,
            update.weight,
        ),
    )


def _body(
    kinematics: KinematicModel, content: SceneContent, update: AttachedObjectUpdate
) -> CollisionObject:
    """Return the object to attach at its pose in the model frame."""
    id_ = update.object.id
    if update.object.has_shapes:
        return build_object(kinematics, content, update.object)
    if id_ in content.objects:
        return content.objects[id_]
    if id_ in content.attached:
        return _in_world(kinematics, content, content.attached[id_])
    raise object_error(
        f"object '{id_}' is not in the world, so it cannot be attached to link "
        f"'{update.link_name}'; add it first, or give its shapes "
        f'{nearest(id_, tuple(content.objects))}'.rstrip()
    )


def _append(
    kinematics: KinematicModel, content: SceneContent, update: AttachedObjectUpdate
) -> SceneContent:
    old = content.attached[update.object.id]
    if old.link_name != update.link_name:
        raise object_error(
            f"object '{old.id}' is attached to link '{old.link_name}', so nothing can be "
            f"appended to it on link '{update.link_name}'"
        )
    body = old.object
    if update.object.has_shapes:
        added = build_object(kinematics, content, update.object)
        on_link = inverse_pose(kinematics.link_pose(content.q, old.link_name)) @ added.pose
        if given_pose(update.object) is not None:
            body = body.at(on_link)
        body = merged(body, added.at(on_link))
    touch_links = tuple(dict.fromkeys((*old.touch_links, *update.touch_links)))
    return _with_attached(
        content,
        replace(
            old,
            object=body,
            touch_links=touch_links,
            detach_posture=update.detach_posture
            if update.detach_posture.points
            else old.detach_posture,
            weight=update.weight or old.weight,
        ),
    )


def _with_attached(content: SceneContent, attached: AttachedObject) -> SceneContent:
    return replace(
        content,
        attached=with_item(content.attached, attached.id, attached),
        objects=without_items(content.objects, attached.id),
    )


def _detach(
    kinematics: KinematicModel, content: SceneContent, update: AttachedObjectUpdate
) -> SceneContent:
    id_, link = update.object.id, update.link_name
    if link:
        _check_link(kinematics, link, id_)
    if not id_:
        gone = [item for item in content.attached.values() if link in ('', item.link_name)]
    else:
        found = content.attached.get(id_)
        if found is None:
            raise object_error(
                f"object '{id_}' is not attached, so it cannot be detached "
                f'{nearest(id_, tuple(content.attached))}'.rstrip()
            )
        if link not in ('', found.link_name):
            raise object_error(
                f"object '{id_}' is attached to link '{found.link_name}', not to '{link}'"
            )
        gone = [found]
    objects = content.objects
    for item in gone:
        if item.id not in objects:
            objects = with_item(objects, item.id, _in_world(kinematics, content, item))
    return replace(
        content,
        attached=without_items(content.attached, *(item.id for item in gone)),
        objects=objects,
    )


def _in_world(
    kinematics: KinematicModel, content: SceneContent, item: AttachedObject
) -> CollisionObject:
    pose: Matrix = kinematics.link_pose(content.q, item.link_name) @ item.object.pose
    return item.object.at(pose)
