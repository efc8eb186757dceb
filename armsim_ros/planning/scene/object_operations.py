# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Edits of the objects in the world and on the robot: each changes a draft, or refuses."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.errors import nearest
from armsim_ros.model.geometry import Geometry, Mesh, Plane
from armsim_ros.model.transforms import inverse_pose
from armsim_ros.planning.scene.content import SceneDraft
from armsim_ros.planning.scene.objects import (
    AttachedObject,
    check_pose,
    checked_shape,
    CollisionObject,
    object_error,
    ObjectOperation,
    ObjectShape,
    OCTOMAP_ID,
)

_KINDS = ('primitive', 'mesh', 'plane')


def apply_object(draft: SceneDraft, item: CollisionObject) -> None:
    """
    Do one operation on a world object.

    :raises PlanningError: INVALID_OBJECT_NAME or FRAME_TRANSFORM_FAILURE with the reason.
    """
    operation = _known_operation(item)
    if operation is ObjectOperation.REMOVE:
        _remove(draft, item.id)
        return
    _check_id(item.id)
    old = draft.objects.get(item.id)
    if operation is ObjectOperation.MOVE:
        draft.objects[item.id] = _moved(draft, old, item)
        return
    body = _built(draft, item)
    if operation is ObjectOperation.APPEND and old is not None:
        body = _merged(old, body)
    elif old is not None and body.type.empty:
        body = replace(body, type=old.type)
    draft.objects[item.id] = body


def apply_attached(draft: SceneDraft, item: AttachedObject) -> None:
    """
    Do one operation on an attached object.

    :raises PlanningError: INVALID_OBJECT_NAME, INVALID_LINK_NAME or FRAME_TRANSFORM_FAILURE.
    """
    operation = _known_operation(item.object)
    if operation is ObjectOperation.REMOVE:
        _detach(draft, item)
        return
    _check_id(item.id)
    if operation is ObjectOperation.MOVE:
        raise object_error(
            f"attached object '{item.id}' cannot be moved on its link; detach it, "
            'or attach it again with another pose'
        )
    _check_link(draft, item)
    if operation is ObjectOperation.APPEND and item.id in draft.attached:
        draft.attach(_appended(draft, item))
    else:
        draft.attach(_attached(draft, item))


def _known_operation(item: CollisionObject) -> ObjectOperation:
    """Return what to do; PlanningError for a number that is no operation."""
    try:
        return ObjectOperation(item.operation)
    except ValueError:
        raise object_error(
            f"object '{item.id}': operation {item.operation} is unknown; allowed: "
            + ', '.join(f'{each.name} {each.value}' for each in ObjectOperation)
        ) from None


def _check_id(id_: str) -> None:
    """Refuse an id that no object may have."""
    if not id_:
        raise object_error('an object needs an id that is not empty')
    if id_ == OCTOMAP_ID:
        raise object_error(f"the id '{OCTOMAP_ID}' is kept for octomaps, choose another")


# -------------------------------------------------------------------- in the world


def _built(draft: SceneDraft, item: CollisionObject) -> CollisionObject:
    """
    Return the object that an ADD or APPEND describes, in the model frame.

    Where the object's own pose is not given and there is a single shape, the shape's pose
    becomes the object's.
    """
    what = f"object '{item.id}'"
    if not item.shapes:
        raise object_error(f'{what} has no shape; give primitives, meshes or planes')
    shapes = tuple(checked_shape(shape, f'{_kind(shape.geometry)} {number} of {what}')
                   for number, shape in enumerate(item.shapes))
    pose, shapes = _single_shape(_given_pose(item), shapes)
    subframes = {
        name: check_pose(value, f"subframe '{name}' of {what}")
        for name, value in item.subframes.items()
    }
    body = replace(item, shapes=shapes, subframes=MappingProxyType(subframes))
    return body.at(_in_model_frame(draft, item, pose))


def _given_pose(item: CollisionObject) -> Matrix | None:
    """Return the object's own pose, None where it is the identity."""
    pose = check_pose(item.pose, f"the pose of object '{item.id}'")
    return None if np.array_equal(pose, np.eye(4)) else pose


def _single_shape(
    pose: Matrix | None, shapes: tuple[ObjectShape, ...]
) -> tuple[Matrix | None, tuple[ObjectShape, ...]]:
    """Give the pose of an only shape to its object where that has none."""
    if pose is None and len(shapes) == 1:
        return shapes[0].pose, (ObjectShape(shapes[0].geometry),)
    return pose, shapes


def _in_model_frame(
    draft: SceneDraft, item: CollisionObject, pose: Matrix | None
) -> Matrix:
    header = draft.frame_pose(item.frame_id)
    return check_pose(
        header if pose is None else header @ pose, f"the pose of object '{item.id}'")


def _merged(old: CollisionObject, new: CollisionObject) -> CollisionObject:
    """Return the old object with the shapes and subframes of another, each where it stands."""
    shift = inverse_pose(old.pose) @ new.pose
    shapes = tuple(ObjectShape(item.geometry, shift @ item.pose) for item in new.shapes)
    subframes = {name: shift @ pose for name, pose in new.subframes.items()}
    return replace(
        old,
        shapes=old.shapes + shapes,
        subframes=MappingProxyType({**old.subframes, **subframes}),
        type=old.type if new.type.empty else new.type,
    )


def _remove(draft: SceneDraft, id_: str) -> None:
    if id_ and id_ not in draft.objects:
        hint = nearest(id_, tuple(draft.objects))
        if id_ in draft.attached:
            hint = f"it is attached to link '{draft.attached[id_].link_name}', detach it first"
        raise object_error(
            f"object '{id_}' is not in the world, so it cannot be removed {hint}".rstrip()
        )
    draft.remove((id_,) if id_ else draft.objects)


def _moved(
    draft: SceneDraft, old: CollisionObject | None,
    item: CollisionObject,
) -> CollisionObject:
    if old is None:
        raise object_error(
            f"object '{item.id}' is not in the world, so it cannot be moved "
            f'{nearest(item.id, tuple(draft.objects))}'.rstrip()
        )
    pose = _given_pose(item)
    if not any(item.shape_poses):
        return old.at(_in_model_frame(draft, item, pose))
    pose, shapes = _single_shape(pose, _moved_shapes(old, item))
    return replace(old.at(_in_model_frame(draft, item, pose)), shapes=shapes)


def _moved_shapes(old: CollisionObject, item: CollisionObject) -> tuple[ObjectShape, ...]:
    """Return the shapes at the poses that a MOVE gives."""
    given = {kind: list(poses) for kind, poses in zip(_KINDS, item.shape_poses, strict=True)}
    kinds = [_kind(shape.geometry) for shape in old.shapes]
    for kind, poses in given.items():
        if len(poses) != kinds.count(kind):
            raise object_error(
                f"object '{item.id}' has {kinds.count(kind)} shapes of kind {kind}, but "
                f'the move gives {len(poses)} poses; give one a shape, or none at all'
            )
    what = f"a shape's pose of object '{item.id}'"
    return tuple(
        ObjectShape(shape.geometry, check_pose(given[kind].pop(0), what))
        for kind, shape in zip(kinds, old.shapes, strict=True)
    )


def _kind(geometry: Geometry) -> str:
    if isinstance(geometry, Mesh):
        return 'mesh'
    return 'plane' if isinstance(geometry, Plane) else 'primitive'


# -------------------------------------------------------------------- on the robot


def _check_link(draft: SceneDraft, item: AttachedObject) -> None:
    draft.check_link(item.link_name, f"object '{item.id}' cannot be attached to")


def _attached(draft: SceneDraft, item: AttachedObject) -> AttachedObject:
    link, body = item.link_name, _in_world(draft, item)
    on_link = inverse_pose(draft.link_pose(link)) @ body.pose
    return replace(
        item, object=body.at(on_link, link), touch_links=tuple(dict.fromkeys(item.touch_links)))


def _in_world(draft: SceneDraft, item: AttachedObject) -> CollisionObject:
    """Return the object to attach at its pose in the model frame."""
    if item.object.shapes:
        return _built(draft, item.object)
    if item.id in draft.objects:
        return draft.objects[item.id]
    if item.id in draft.attached:
        return _released(draft, draft.attached[item.id])
    raise object_error(
        f"object '{item.id}' is not in the world, so it cannot be attached to link "
        f"'{item.link_name}'; add it first, or give its shapes "
        f'{nearest(item.id, tuple(draft.objects))}'.rstrip()
    )


def _appended(draft: SceneDraft, item: AttachedObject) -> AttachedObject:
    old = draft.attached[item.id]
    if old.link_name != item.link_name:
        raise object_error(
            f"object '{old.id}' is attached to link '{old.link_name}', so nothing can be "
            f"appended to it on link '{item.link_name}'"
        )
    body = old.object
    if item.object.shapes:
        added = _built(draft, item.object)
        on_link = inverse_pose(draft.link_pose(old.link_name)) @ added.pose
        if _given_pose(item.object) is not None:
            body = body.at(on_link, old.link_name)
        body = _merged(body, added.at(on_link))
    return AttachedObject(
        old.link_name,
        body,
        tuple(dict.fromkeys((*old.touch_links, *item.touch_links))),
        item.detach_posture if len(item.detach_posture) else old.detach_posture,
        item.weight or old.weight,
    )


def _detach(draft: SceneDraft, item: AttachedObject) -> None:
    id_, link = item.id, item.link_name
    if link:
        _check_link(draft, item)
    if not id_:
        gone = [each for each in draft.attached.values() if link in ('', each.link_name)]
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
    for each in gone:
        del draft.attached[each.id]
        draft.objects.setdefault(each.id, _released(draft, each))


def _released(draft: SceneDraft, item: AttachedObject) -> CollisionObject:
    """Return an attached object as one of the world, where it is now."""
    return item.object.at(draft.link_pose(item.link_name) @ item.object.pose)
