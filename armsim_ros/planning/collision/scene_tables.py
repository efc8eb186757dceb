# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The collision tables of a scene, which follow its edits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.planning.collision.bodies import (
    BodyKey,
    link_shapes,
    object_shapes,
    octomap_shapes,
    only_moved,
    PlacedShape,
    shape_poses,
)
from armsim_ros.planning.collision.contacts import BodyType
from armsim_ros.planning.collision.tables import CollisionTables
from armsim_ros.planning.scene.content import SceneContent
from armsim_ros.planning.scene.objects import AttachedObject, CollisionObject, OCTOMAP_ID
from armsim_ros.planning.scene.octomap import Octomap

LINK, ATTACHED, OBJECT = (
    BodyType.ROBOT_LINK, BodyType.ROBOT_ATTACHED, BodyType.WORLD_OBJECT
)

#: Parts of a scene's content that matter to collisions.
PARTS = ('acm', 'link_scale', 'link_padding', 'objects', 'attached', 'octomap')
#: Shapes of the world in a table: what a table costs grows with their square.
MOST_SHAPES = 100

Source = tuple[CollisionObject | AttachedObject | Octomap | None, float]
"""What the shapes of a body are made of: an object, None for a link, and the link's scale."""


class SceneTables:
    """
    Collision tables that hold a scene: a single table for some objects, several for many.

    Each table has all shapes of the robot and of what it carries, and a part of the world; the
    first also checks the robot against itself. What only moves is placed anew; a table that
    holds other shapes or follows other rules or padding than before is made anew.

    :param kinematics: the robot.
    :param content: what they hold at first.
    """

    def __init__(self, kinematics: KinematicModel, content: SceneContent) -> None:
        self._kinematics = kinematics
        self._bodies: dict[BodyKey, tuple[Source, list[PlacedShape]]] = {}
        self.content = content
        #: How many contents were taken over that mattered.
        self.edits = 0
        self.tables: list[CollisionTables] = []
        self._make(content)

    def follow(self, content: SceneContent) -> None:
        """Take over another content; what is the same is left alone."""
        held = self.holds(content)
        before, self.content = self.content, content
        if not held:
            self.edits += 1
            self._make(before)

    def holds(self, content: SceneContent) -> bool:
        """Return whether a content collides as the last one did."""
        return all(getattr(content, part) is getattr(self.content, part) for part in PARTS)

    def _make(self, before: SceneContent) -> None:
        content, links = self.content, self._kinematics.robot.links
        sources: dict[BodyKey, Source] = {
            **{(LINK, link): (None, content.link_scale.get(link, 1.0)) for link in links},
            **{(ATTACHED, id_): (item, content.link_scale.get(item.link_name, 1.0))
               for id_, item in content.attached.items()},
            **{(OBJECT, id_): (item, 1.0) for id_, item in content.objects.items()},
        }
        if content.octomap is not None:
            sources[OBJECT, OCTOMAP_ID] = content.octomap, 1.0
        self._bodies = {key: (source, self._shapes(key, source))
                        for key, source in sources.items()}
        # What is far from the base is the most likely to touch: a pair that touches ends a check.
        carried = sorted(
            (shape for key, (_, shapes) in self._bodies.items() if key[0] is not OBJECT
             for shape in shapes), key=lambda shape: -shape.joint)
        pairs, names = content.acm.differences(before.acm)
        tables: list[CollisionTables] = []
        for number, standing in enumerate(self._parts()):
            table = self.tables[number] if number < len(self.tables) else None
            held = {shape.body.name for shape in (*carried, *standing)}
            if (
                table is None or content.link_padding != before.link_padding
                or table.shapes != [*carried, *standing]
                or not held.isdisjoint(names) or any(held.issuperset(pair) for pair in pairs)
            ):
                table = CollisionTables(
                    self._kinematics, carried, standing, content, among=number == 0)
            tables.append(table)
        self.tables = tables

    def _parts(self) -> Iterator[list[PlacedShape]]:
        """Yield the shapes of the world, table by table; an octomap has its own, the last."""
        part: list[PlacedShape] = []
        for id_ in self.content.objects:
            if len(part) >= MOST_SHAPES:
                yield part
                part = []
            part += self._bodies[OBJECT, id_][1]
        yield part
        if self.content.octomap is not None:
            yield self._bodies[OBJECT, OCTOMAP_ID][1]

    def _shapes(self, key: BodyKey, source: Source) -> list[PlacedShape]:
        """Return the shapes of a body: those that there are, where it is now, or new ones."""
        before, shapes = self._bodies.get(key, (None, []))
        if source == before:
            return shapes
        item, scale = source
        if item is None:
            return link_shapes(self._kinematics, key[1], scale)
        if isinstance(item, Octomap):
            return octomap_shapes(item)
        poses = list(shape_poses(self._kinematics, item))
        was = before and before[0]
        if (was is None or isinstance(was, Octomap) or before != (was, 1.0) or scale != 1.0
                or not only_moved(was, item)):
            return object_shapes(self._kinematics, item, poses, scale)
        shapes = [replace(shape, pose=pose) for shape, pose in zip(shapes, poses, strict=True)]
        for table in self.tables:
            table.place(key, shapes)
        return shapes
