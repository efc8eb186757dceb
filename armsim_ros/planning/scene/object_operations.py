# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Edits of the objects in the world and on the robot: each changes a draft, or refuses."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.errors import nearest, PlanningError
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


def apply_object(draft: SceneDraft, item: CollisionObject) -> None:
    """
    Do an operation on a world object.

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
        body = _extended(old, body)
    elif old is not None and body.type.empty:
        body = replace(body, type=old.type)
    draft.objects[item.id] = body


def place_object(draft: SceneDraft, item: CollisionObject) -> None:
    """
    Add a world object, or replace it; the poses of object and shapes are taken as they are given.

    :raises PlanningError: INVALID_OBJECT_NAME or FRAME_TRANSFORM_FAILURE with the reason.
    """
    _check_id(item.id)
    draft.objects[item.id] = _as_given(draft, item)


def apply_attached(draft: SceneDraft, item: AttachedObject) -> None:
    """
    Do an operation on an attached object.

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
            'or attach it again with another pose')
    _check_link(draft, item)
    if operation is ObjectOperation.APPEND and item.id in draft.attached:
        draft.attach(_appended(draft, item))
    elif operation is ObjectOperation.APPEND or item.object.shapes:
        draft.attach(_on_link(draft, item, _built(draft, item.object)))
    else:
        draft.attach(_on_link(draft, item, _in_world(draft, item)))


def apply_attached_in_state(draft: SceneDraft, item: AttachedObject) -> None:
    """
    Do an operation on an attached object of a request's start state; the world stays as it is.

    The poses of object and shapes are taken as they are given.

    :raises PlanningError: INVALID_OBJECT_NAME, INVALID_LINK_NAME or FRAME_TRANSFORM_FAILURE.
    """
    operation = _known_operation(item.object)
    if operation is ObjectOperation.REMOVE:
        if item.id not in draft.attached:
            raise _not_attached(draft, item.id)
        del draft.attached[item.id]
        return
    _check_id(item.id)
    if operation is not ObjectOperation.ADD:
        raise object_error(
            f"attached object '{item.id}': a start state takes ADD and REMOVE only, not "
            f'{operation.name}')
    _check_link(draft, item)
    draft.attached[item.id] = _on_link(draft, item, _as_given(draft, item.object))


def _known_operation(item: CollisionObject) -> ObjectOperation:
    """Return what to do; PlanningError for a number that is not an operation."""
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
    pose, shapes = _single_shape(_given_pose(item), item.shapes)
    return _as_given(draft, replace(
        item, pose=np.eye(4) if pose is None else pose, shapes=shapes))


def _as_given(draft: SceneDraft, item: CollisionObject) -> CollisionObject:
    """Return the object in the model frame, with its own pose and those of its shapes."""
    what = f"object '{item.id}'"
    if not item.shapes:
        raise object_error(f'{what} has no shape; give primitives, meshes or planes')
    shapes = tuple(checked_shape(shape, f'{_kind(shape.geometry)} {number} of {what}')
                   for number, shape in enumerate(item.shapes))
    subframes = {
        name: check_pose(value, f"subframe '{name}' of {what}")
        for name, value in item.subframes.items()
    }
    body = replace(item, shapes=shapes, subframes=MappingProxyType(subframes))
    return body.at(_in_model_frame(draft, item, _given_pose(item)))


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


def _extended(old: CollisionObject, new: CollisionObject) -> CollisionObject:
    """Return the old object with the shapes of another, in its own frame, and its subframes."""
    return replace(
        old, shapes=old.shapes + new.shapes, subframes=new.subframes,
        type=old.type if new.type.empty else new.type)


def _remove(draft: SceneDraft, id_: str) -> None:
    if id_ and id_ not in draft.objects:
        hint = nearest(id_, tuple(draft.objects))
        if id_ in draft.attached:
            hint = f"it is attached to link '{draft.attached[id_].link_name}', detach it first"
        raise object_error(f"object '{id_}' is not in the world, so it cannot be removed"
                           + (f'; {hint}' if hint else ''))
    draft.remove((id_,) if id_ else draft.objects)


def _moved(
    draft: SceneDraft, old: CollisionObject | None, item: CollisionObject
) -> CollisionObject:
    if old is None:
        raise object_error(
            f"object '{item.id}' is not in the world, so it cannot be moved "
            f'{nearest(item.id, tuple(draft.objects))}'.rstrip())
    given, shapes = item.shape_poses, old.shapes
    if given:
        if len(given) != len(shapes):
            raise object_error(
                f"object '{item.id}' has {len(shapes)} shapes, but the move gives {len(given)} "
                'shape poses; give one for each shape, or none at all')
        what = f"a shape's pose of object '{item.id}'"
        shapes = tuple(ObjectShape(shape.geometry, check_pose(pose, what))
                       for shape, pose in zip(shapes, given, strict=True))
    return replace(old.at(_in_model_frame(draft, item, _given_pose(item))), shapes=shapes)


def _kind(geometry: Geometry) -> str:
    if isinstance(geometry, Mesh):
        return 'mesh'
    return 'plane' if isinstance(geometry, Plane) else 'primitive'


# -------------------------------------------------------------------- on the robot


def _check_link(draft: SceneDraft, item: AttachedObject) -> None:
    draft.check_link(item.link_name, f"object '{item.id}' cannot be attached to")


def _on_link(draft: SceneDraft, item: AttachedObject, body: CollisionObject) -> AttachedObject:
    """Return an attached object whose body is given in the model frame."""
    pose = inverse_pose(draft.link_pose(item.link_name)) @ body.pose
    return replace(
        item, object=body.at(pose, item.link_name),
        touch_links=tuple(dict.fromkeys(item.touch_links)))


def _in_world(draft: SceneDraft, item: AttachedObject) -> CollisionObject:
    """Return the object of the world that is attached by its id."""
    if item.id in draft.objects:
        return draft.objects[item.id]
    hint = nearest(item.id, tuple(draft.objects))
    if item.id in draft.attached:
        hint = f"it is attached to link '{draft.attached[item.id].link_name}' already"
    raise object_error(
        f"object '{item.id}' is not in the world, so it cannot be attached to link "
        f"'{item.link_name}'; add it first, or give its shapes {hint}".rstrip())


def _appended(draft: SceneDraft, item: AttachedObject) -> AttachedObject:
    old = draft.attached[item.id]
    if old.link_name != item.link_name:
        raise object_error(
            f"object '{old.id}' is attached to link '{old.link_name}', so nothing can be "
            f"appended to it on link '{item.link_name}'")
    added = _built(draft, item.object)
    body = replace(
        old.object, shapes=added.shapes + old.object.shapes,
        subframes=MappingProxyType({**old.object.subframes, **added.subframes}),
        type=old.object.type if added.type.empty else added.type)
    if _given_pose(item.object) is not None:
        on_link = inverse_pose(draft.link_pose(old.link_name)) @ added.pose
        body = body.at(on_link, old.link_name)
    return AttachedObject(
        old.link_name, body, tuple(dict.fromkeys((*old.touch_links, *item.touch_links))),
        item.detach_posture if len(item.detach_posture) else old.detach_posture,
        item.weight or old.weight)


def _detach(draft: SceneDraft, item: AttachedObject) -> None:
    id_, link = item.id, item.link_name
    if link:
        _check_link(draft, item)
    if not id_:
        gone = [each for each in draft.attached.values() if link in ('', each.link_name)]
    else:
        found = draft.attached.get(id_)
        if found is None:
            raise _not_attached(draft, id_)
        if link not in ('', found.link_name):
            raise object_error(
                f"object '{id_}' is attached to link '{found.link_name}', not to '{link}'")
        gone = [found]
    for each in gone:
        del draft.attached[each.id]
        if each.id not in draft.objects:
            draft.objects[each.id] = _released(draft, each)
            if each.id in draft.first_colors:
                draft.colors[each.id] = draft.first_colors[each.id]


def _not_attached(draft: SceneDraft, id_: str) -> PlanningError:
    return object_error(
        f"object '{id_}' is not attached, so it cannot be detached "
        f'{nearest(id_, tuple(draft.attached))}'.rstrip())


def _released(draft: SceneDraft, item: AttachedObject) -> CollisionObject:
    """Return an attached object as an object of the world, where it is now."""
    return item.object.at(draft.link_pose(item.link_name) @ item.object.pose)
