# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The collision tables of a scene, kept up with its edits."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from armsim_ros.arrays import Matrix
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.planning.collision.bodies import (
    attached_poses,
    attached_shapes,
    BodyKey,
    link_shapes,
    PlacedShape,
    world_poses,
    world_shapes,
)
from armsim_ros.planning.collision.contacts import BodyType
from armsim_ros.planning.collision.tables import CollisionTables
from armsim_ros.planning.scene.content import SceneContent
from armsim_ros.planning.scene.objects import AttachedObject, CollisionObject, ObjectShape

#: Parts of a scene's content that matter to collisions.
PARTS = ('acm', 'link_scale', 'link_padding', 'objects', 'attached')
#: Shapes of the world in one table: what a table costs grows with their square.
MOST_SHAPES = 100

LINK, ATTACHED, OBJECT = (
    BodyType.ROBOT_LINK, BodyType.ROBOT_ATTACHED, BodyType.WORLD_OBJECT
)


class SceneTables:
    """
    Collision tables that hold a scene: one for some objects, several for many.

    Each table has all shapes of the robot and of what it carries, and a part of the world; the
    first one also checks the robot against itself. What only moves is placed anew; for every
    other edit the tables that it concerns are made anew.

    :param kinematics: the robot.
    :param content: what they hold at first.
    """

    def __init__(self, kinematics: KinematicModel, content: SceneContent) -> None:
        self._kinematics = kinematics
        self._content = content
        self._shapes: dict[BodyKey, list[PlacedShape]] = {}
        #: Object -> number of its table; the objects and the count of shapes of each table.
        self._table_of: dict[str, int] = {}
        self._ids: list[dict[str, None]] = [{}]
        self._sizes = [0]
        self.tables: list[CollisionTables] = []
        for id_ in content.objects:
            self._take_in(id_)
        self._make(range(len(self._ids)))

    @property
    def content(self) -> SceneContent:
        """What the tables hold."""
        return self._content

    def follow(self, content: SceneContent) -> None:
        """Take over another content; what is the same is left alone."""
        before, self._content = self._content, content
        if all(getattr(content, part) is getattr(before, part) for part in PARTS):
            return
        stale = self._follow_objects(before.objects, content.objects)
        if self._follow_links(before) | self._follow_attached(before.attached, content.attached):
            stale = set(range(len(self._ids)))
        pairs, names = content.acm.differences(before.acm)
        if pairs or names:
            robot = {*self._kinematics.robot.links, *content.attached}
            stale.update(
                number for number, ids in enumerate(self._ids)
                if any((a in robot or a in ids) and (b in robot or b in ids) for a, b in pairs)
                or any(name in robot or name in ids for name in names)
            )
        padded = content.link_padding != before.link_padding
        for number, tables in enumerate(self.tables):
            if padded and number not in stale:
                tables.set_padding(content)
        self._make(stale)

    # ---------------------------------------------------------------- what an edit changes

    def _follow_links(self, before: SceneContent) -> bool:
        """Return whether a link has another size."""
        if self._content.link_scale is before.link_scale:
            return False
        changed = [
            link for link in self._kinematics.robot.links
            if self._content.link_scale.get(link, 1.0) != before.link_scale.get(link, 1.0)
        ]
        for link in changed:
            self._shapes.pop((LINK, link), None)
        return bool(changed)

    def _follow_attached(
        self, old: Mapping[str, AttachedObject], new: Mapping[str, AttachedObject]
    ) -> bool:
        """Place what has moved on its link; return whether the robot carries anything else."""
        if old is new:
            return False
        anew = False
        for id_ in (*old, *(id_ for id_ in new if id_ not in old)):
            was, item = old.get(id_), new.get(id_)
            if was is item:
                continue
            if (
                was is not None and item is not None
                and was.link_name == item.link_name
                and was.touch_links == item.touch_links
                and _same_geometry(was.object.shapes, item.object.shapes)
            ):
                self._place((ATTACHED, id_), attached_poses(self._kinematics, item), self.tables)
            else:
                self._shapes.pop((ATTACHED, id_), None)
                anew = True
        return anew

    def _follow_objects(
        self, old: Mapping[str, CollisionObject], new: Mapping[str, CollisionObject]
    ) -> set[int]:
        """Place what has moved; return the numbers of the tables that hold anything else now."""
        if old is new:
            return set()
        stale = {self._put_out(id_) for id_ in old if id_ not in new}
        for id_, item in new.items():
            was = old.get(id_)
            if was is item:
                continue
            if was is None:
                stale.add(self._take_in(id_))
                continue
            number = self._table_of[id_]
            if _same_geometry(was.shapes, item.shapes):
                self._place((OBJECT, id_), world_poses(item), self.tables[number:number + 1])
            else:
                self._shapes.pop((OBJECT, id_), None)
                stale.add(number)
        while len(self._ids) > 1 and not self._ids[-1]:
            self._ids.pop()
            self._sizes.pop()
        del self.tables[len(self._ids):]
        return {number for number in stale if number < len(self._ids)}

    def _take_in(self, id_: str) -> int:
        """Give an object to a table with room; return the table's number."""
        number = len(self._ids) - 1
        if self._sizes[number] >= MOST_SHAPES:
            number = min(range(len(self._sizes)), key=self._sizes.__getitem__)
        if self._sizes[number] >= MOST_SHAPES:
            number = len(self._ids)
            self._ids.append({})
            self._sizes.append(0)
        self._ids[number][id_] = None
        self._sizes[number] += len(self._content.objects[id_].shapes)
        self._table_of[id_] = number
        return number

    def _put_out(self, id_: str) -> int:
        """Take an object from its table; return the table's number."""
        number = self._table_of.pop(id_)
        del self._ids[number][id_]
        self._sizes[number] -= len(self._shapes.pop((OBJECT, id_)))
        return number

    def _place(
        self, key: BodyKey, poses: Iterable[Matrix], tables: Sequence[CollisionTables]
    ) -> None:
        """Move a body that is in some tables."""
        self._shapes[key] = [
            replace(shape, pose=pose)
            for shape, pose in zip(self._shapes[key], poses, strict=True)
        ]
        for each in tables:
            each.place(key, [shape.pose for shape in self._shapes[key]])

    # ---------------------------------------------------------------- tables

    def _make(self, numbers: Iterable[int]) -> None:
        """Make tables anew, and those that do not exist yet."""
        carried = [
            *(shape for link in self._kinematics.robot.links for shape in self._of(LINK, link)),
            *(shape for id_ in self._content.attached for shape in self._of(ATTACHED, id_)),
        ]
        for number in sorted(numbers):
            standing = [
                shape for id_ in self._ids[number] for shape in self._of(OBJECT, id_)
            ]
            self._sizes[number] = len(standing)
            self.tables[number:number + 1] = [CollisionTables(
                self._kinematics, carried, standing, self._content, among=number == 0
            )]

    def _of(self, kind: BodyType, name: str) -> list[PlacedShape]:
        """Return the shapes of a body, made once."""
        found = self._shapes.get((kind, name))
        if found is None:
            content, kinematics = self._content, self._kinematics
            if kind is LINK:
                found = link_shapes(kinematics, name, content.link_scale.get(name, 1.0))
            elif kind is ATTACHED:
                found = attached_shapes(kinematics, content.attached[name])
            else:
                found = world_shapes(content.objects[name])
            self._shapes[kind, name] = found
        return found


def _same_geometry(before: Sequence[ObjectShape], after: Sequence[ObjectShape]) -> bool:
    return len(before) == len(after) and all(
        one.geometry is other.geometry for one, other in zip(before, after, strict=True)
    )
