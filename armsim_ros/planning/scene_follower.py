# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What differs between two contents of a scene, taken over into the collision tables."""

from __future__ import annotations

from collections.abc import Sequence

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.planning.collision_bodies import (
    attached_poses,
    attached_shapes,
    link_shapes,
    PlacedShape,
    world_poses,
    world_shapes,
)
from armsim_ros.planning.collision_tables import CollisionTables
from armsim_ros.planning.contacts import BodyType
from armsim_ros.planning.scene_content import SceneContent
from armsim_ros.planning.world_object import ObjectShape

#: Parts of a scene's content that matter to collisions.
PARTS = ('acm', 'link_scale', 'link_padding', 'objects', 'attached')


def same_for_collisions(content: SceneContent, before: SceneContent) -> bool:
    """Return whether nothing differs that matters to collisions."""
    return all(getattr(content, part) is getattr(before, part) for part in PARTS)


def follow(
    kinematics: KinematicModel,
    tables: CollisionTables,
    content: SceneContent,
    before: SceneContent | None,
) -> None:
    """
    Bring the tables from one content to another; what is the same is left alone.

    :param before: what the tables hold; None for nothing, not even the robot.
    """
    added: list[PlacedShape] = []
    if before is None or content.link_scale is not before.link_scale:
        added += _changed_links(kinematics, tables, content, before)
    if before is None or content.objects is not before.objects:
        added += _changed_objects(tables, content, before)
    if before is None or content.attached is not before.attached:
        added += _changed_attached(kinematics, tables, content, before)
    tables.renew(
        added,
        content,
        rules=None if before is None else content.acm.differences(before.acm),
        padded=before is None or content.link_padding is not before.link_padding,
    )


def _changed_links(
    kinematics: KinematicModel,
    tables: CollisionTables,
    content: SceneContent,
    before: SceneContent | None,
) -> list[PlacedShape]:
    added = []
    for link in kinematics.robot.links:
        scale = content.link_scale.get(link, 1.0)
        if before is None or scale != before.link_scale.get(link, 1.0):
            tables.drop((BodyType.ROBOT_LINK, link))
            added += link_shapes(kinematics, link, scale)
    return added


def _changed_objects(
    tables: CollisionTables, content: SceneContent, before: SceneContent | None
) -> list[PlacedShape]:
    old = {} if before is None else before.objects
    added = []
    for id_ in old:
        if id_ not in content.objects:
            tables.drop((BodyType.WORLD_OBJECT, id_))
    for id_, item in content.objects.items():
        was = old.get(id_)
        if was is item:
            continue
        key = (BodyType.WORLD_OBJECT, id_)
        if was is not None and _same_geometry(was.shapes, item.shapes):
            tables.place(key, world_poses(item))
        else:
            tables.drop(key)
            added += world_shapes(item)
    return added


def _changed_attached(
    kinematics: KinematicModel,
    tables: CollisionTables,
    content: SceneContent,
    before: SceneContent | None,
) -> list[PlacedShape]:
    old = {} if before is None else before.attached
    added = []
    for id_ in old:
        if id_ not in content.attached:
            tables.drop((BodyType.ROBOT_ATTACHED, id_))
    for id_, item in content.attached.items():
        was = old.get(id_)
        if was is item:
            continue
        key = (BodyType.ROBOT_ATTACHED, id_)
        if (
            was is not None
            and was.link_name == item.link_name
            and was.touch_links == item.touch_links
            and _same_geometry(was.object.shapes, item.object.shapes)
        ):
            tables.place(key, attached_poses(kinematics, item))
        else:
            tables.drop(key)
            added += attached_shapes(kinematics, item)
    return added


def _same_geometry(before: Sequence[ObjectShape], after: Sequence[ObjectShape]) -> bool:
    return len(before) == len(after) and all(
        one.geometry is other.geometry for one, other in zip(before, after, strict=True)
    )
