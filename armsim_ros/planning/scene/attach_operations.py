# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Taking objects from the world onto the robot and back."""

from __future__ import annotations

from dataclasses import replace

from armsim_ros.arrays import Matrix
from armsim_ros.errors import MoveItErrorCode, nearest, PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.transforms import inverse_pose
from armsim_ros.planning.scene.attached_object import AttachedObject
from armsim_ros.planning.scene.draft import SceneDraft
from armsim_ros.planning.scene.object_checks import object_error
from armsim_ros.planning.scene.object_operations import (
    build_object,
    check_id,
    given_pose,
    known_operation,
    merged,
)
from armsim_ros.planning.scene.update import AttachedObjectUpdate, ObjectOperation
from armsim_ros.planning.scene.world_object import CollisionObject


def apply_attached(
    kinematics: KinematicModel, draft: SceneDraft, update: AttachedObjectUpdate
) -> None:
    """
    Do one operation on an attached object.

    :raises PlanningError: INVALID_OBJECT_NAME, INVALID_LINK_NAME or FRAME_TRANSFORM_FAILURE.
    """
    operation = known_operation(update.object)
    if operation is ObjectOperation.REMOVE:
        _detach(kinematics, draft, update)
        return
    check_id(update.object.id)
    if operation is ObjectOperation.MOVE:
        raise object_error(
            f"attached object '{update.object.id}' cannot be moved on its link; detach it, "
            'or attach it again with another pose'
        )
    _check_link(kinematics, update.link_name, update.object.id)
    if operation is ObjectOperation.APPEND and update.object.id in draft.attached:
        draft.attach(_appended(kinematics, draft, update))
    else:
        draft.attach(_attached(kinematics, draft, update))


def _check_link(kinematics: KinematicModel, link: str, id_: str) -> None:
    if not kinematics.has_link(link):
        known = tuple(kinematics.robot.links)
        raise PlanningError(
            MoveItErrorCode.INVALID_LINK_NAME,
            f"object '{id_}' cannot be attached to link '{link}', which robot "
            f"'{kinematics.robot.name}' does not have {nearest(link, known)}".rstrip(),
            'planning scene',
        )


def _attached(
    kinematics: KinematicModel, draft: SceneDraft, update: AttachedObjectUpdate
) -> AttachedObject:
    body = _body(kinematics, draft, update)
    pose_of_link = kinematics.link_pose(draft.q, update.link_name)
    return AttachedObject(
        body.at(inverse_pose(pose_of_link) @ body.pose),
        update.link_name,
        tuple(dict.fromkeys(update.touch_links)),
        update.detach_posture,
        update.weight,
    )


def _body(
    kinematics: KinematicModel, draft: SceneDraft, update: AttachedObjectUpdate
) -> CollisionObject:
    """Return the object to attach at its pose in the model frame."""
    id_ = update.object.id
    if update.object.has_shapes:
        return build_object(kinematics, draft, update.object)
    if id_ in draft.objects:
        return draft.objects[id_]
    if id_ in draft.attached:
        return _in_world(kinematics, draft, draft.attached[id_])
    raise object_error(
        f"object '{id_}' is not in the world, so it cannot be attached to link "
        f"'{update.link_name}'; add it first, or give its shapes "
        f'{nearest(id_, tuple(draft.objects))}'.rstrip()
    )


def _appended(
    kinematics: KinematicModel, draft: SceneDraft, update: AttachedObjectUpdate
) -> AttachedObject:
    old = draft.attached[update.object.id]
    if old.link_name != update.link_name:
        raise object_error(
            f"object '{old.id}' is attached to link '{old.link_name}', so nothing can be "
            f"appended to it on link '{update.link_name}'"
        )
    body = old.object
    if update.object.has_shapes:
        added = build_object(kinematics, draft, update.object)
        on_link = inverse_pose(kinematics.link_pose(draft.q, old.link_name)) @ added.pose
        if given_pose(update.object) is not None:
            body = body.at(on_link)
        body = merged(body, added.at(on_link))
    touch_links = tuple(dict.fromkeys((*old.touch_links, *update.touch_links)))
    posture = update.detach_posture if update.detach_posture.points else old.detach_posture
    return replace(
        old,
        object=body,
        touch_links=touch_links,
        detach_posture=posture,
        weight=update.weight or old.weight,
    )


def _detach(
    kinematics: KinematicModel, draft: SceneDraft, update: AttachedObjectUpdate
) -> None:
    id_, link = update.object.id, update.link_name
    if link:
        _check_link(kinematics, link, id_)
    if not id_:
        gone = [item for item in draft.attached.values() if link in ('', item.link_name)]
    else:
        found = draft.attached.get(id_)
        if found is None:
            raise object_error(
                f"object '{id_}' is not attached, so it cannot be detached "
                f'{nearest(id_, tuple(draft.attached))}'.rstrip()
            )
        if link not in ('', found.link_name):
            raise object_error(
                f"object '{id_}' is attached to link '{found.link_name}', not to '{link}'"
            )
        gone = [found]
    for item in gone:
        draft.detach(item, _in_world(kinematics, draft, item))


def _in_world(
    kinematics: KinematicModel, draft: SceneDraft, item: AttachedObject
) -> CollisionObject:
    pose: Matrix = kinematics.link_pose(draft.q, item.link_name) @ item.object.pose
    return item.object.at(pose)
