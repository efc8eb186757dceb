# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Edits of the world: each changes a draft, or refuses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.errors import nearest
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Geometry, Mesh, Plane
from armsim_ros.model.transforms import inverse_pose
from armsim_ros.planning.scene.draft import SceneDraft
from armsim_ros.planning.scene.frames import frame_pose
from armsim_ros.planning.scene.object_checks import check_geometry, check_pose, object_error
from armsim_ros.planning.scene.update import CollisionObjectUpdate, ObjectOperation
from armsim_ros.planning.scene.world_object import CollisionObject, ObjectShape

#: The id that octomaps have in messages; no other object may have it.
OCTOMAP_ID = '<octomap>'


def apply_object(
    kinematics: KinematicModel, draft: SceneDraft, update: CollisionObjectUpdate
) -> None:
    """
    Do one operation on a world object.

    :raises PlanningError: INVALID_OBJECT_NAME or FRAME_TRANSFORM_FAILURE with the reason.
    """
    operation = known_operation(update)
    if operation is ObjectOperation.REMOVE:
        _remove(draft, update.id)
        return
    check_id(update.id)
    if operation is ObjectOperation.MOVE:
        draft.put(_moved(kinematics, draft, update))
        return
    old = draft.objects.get(update.id)
    body = build_object(kinematics, draft, update)
    if operation is ObjectOperation.APPEND and old is not None:
        body = merged(old, body)
    elif old is not None and body.type.empty:
        body = replace(body, type=old.type)
    draft.put(body)


def known_operation(update: CollisionObjectUpdate) -> ObjectOperation:
    """Return the operation of an update; PlanningError for a number that is none."""
    try:
        return ObjectOperation(update.operation)
    except ValueError:
        raise object_error(
            f"object '{update.id}': operation {update.operation} is unknown; allowed: "
            + ', '.join(f'{item.name} {item.value}' for item in ObjectOperation)
        ) from None


def check_id(id_: str) -> None:
    """Refuse an id that no object may have."""
    if not id_:
        raise object_error('an object needs an id that is not empty')
    if id_ == OCTOMAP_ID:
        raise object_error(f"the id '{OCTOMAP_ID}' is kept for octomaps, choose another")


def build_object(
    kinematics: KinematicModel, draft: SceneDraft, update: CollisionObjectUpdate
) -> CollisionObject:
    """
    Return the object that an ADD or APPEND describes, in the model frame.

    Where the object's own pose is not given and there is a single shape, the shape's pose
    becomes the object's.

    :raises PlanningError: INVALID_OBJECT_NAME or FRAME_TRANSFORM_FAILURE.
    """
    what = f"object '{update.id}'"
    if not update.has_shapes:
        raise object_error(f'{what} has no shape; give primitives, meshes or planes')
    shapes = [
        *_shapes(update.primitives, update.primitive_poses, f'primitive of {what}'),
        *_shapes(update.meshes, update.mesh_poses, f'mesh of {what}'),
        *_shapes(update.planes, update.plane_poses, f'plane of {what}'),
    ]
    pose = given_pose(update)
    if len(shapes) == 1 and pose is None:
        pose = shapes[0].pose
        shapes = [ObjectShape(shapes[0].geometry, np.eye(4))]
    header = frame_pose(kinematics, draft, update.frame_id)
    subframes = {
        name: check_pose(value, f"subframe '{name}' of {what}")
        for name, value in update.subframes.items()
    }
    return CollisionObject(
        update.id,
        check_pose(header if pose is None else header @ pose, f'the pose of {what}'),
        tuple(shapes),
        MappingProxyType(subframes),
        update.type,
    )


def given_pose(update: CollisionObjectUpdate) -> Matrix | None:
    """Return the object's own pose, None where it is absent or identity."""
    if update.pose is None:
        return None
    pose = check_pose(update.pose, f"the pose of object '{update.id}'")
    return None if np.array_equal(pose, np.eye(4)) else pose


def merged(old: CollisionObject, new: CollisionObject) -> CollisionObject:
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


def _shapes(
    geometries: Sequence[Geometry], poses: Sequence[Matrix], what: str
) -> list[ObjectShape]:
    if len(poses) > len(geometries):
        raise object_error(
            f'{what}: {len(poses)} poses are given for {len(geometries)} shapes; '
            'at most one pose a shape is allowed'
        )
    shapes = []
    for index, geometry in enumerate(geometries):
        name = f'{what}, number {index}'
        check_geometry(geometry, name)
        pose = check_pose(poses[index], f'the pose of {name}') if index < len(poses) else np.eye(4)
        shapes.append(ObjectShape(geometry, pose))
    return shapes


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
    kinematics: KinematicModel, draft: SceneDraft, update: CollisionObjectUpdate
) -> CollisionObject:
    old = draft.objects.get(update.id)
    if old is None:
        raise object_error(
            f"object '{update.id}' is not in the world, so it cannot be moved "
            f'{nearest(update.id, tuple(draft.objects))}'.rstrip()
        )
    shapes = _moved_shapes(old, update)
    pose = given_pose(update)
    if pose is None and shapes is not None and len(shapes) == 1:
        pose = shapes[0].pose
        shapes = (ObjectShape(shapes[0].geometry, np.eye(4)),)
    header = frame_pose(kinematics, draft, update.frame_id)
    return replace(
        old,
        pose=check_pose(
            header if pose is None else header @ pose, f"the pose of object '{update.id}'"
        ),
        shapes=old.shapes if shapes is None else shapes,
    )


def _moved_shapes(
    old: CollisionObject, update: CollisionObjectUpdate
) -> tuple[ObjectShape, ...] | None:
    """Return the shapes at the poses of a MOVE, None where it gives none."""
    given = {
        'mesh': list(update.mesh_poses),
        'plane': list(update.plane_poses),
        'primitive': list(update.primitive_poses),
    }
    if not any(given.values()):
        return None
    kinds = [_kind(item.geometry) for item in old.shapes]
    for kind, poses in given.items():
        if len(poses) != kinds.count(kind):
            raise object_error(
                f"object '{update.id}' has {kinds.count(kind)} shapes of kind {kind}, but "
                f'the move gives {len(poses)} poses; give one a shape, or none at all'
            )
    what = f"a shape's pose of object '{update.id}'"
    return tuple(
        ObjectShape(item.geometry, check_pose(given[kind].pop(0), what))
        for kind, item in zip(kinds, old.shapes, strict=True)
    )


def _kind(geometry: Geometry) -> str:
    if isinstance(geometry, Mesh):
        return 'mesh'
    return 'plane' if isinstance(geometry, Plane) else 'primitive'
