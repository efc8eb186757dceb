# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a robot state touches itself or the world."""

from __future__ import annotations

from collections.abc import Iterable
import math
from typing import Any

import coal
import numpy as np
from numpy.typing import NDArray

from armsim_ros.planning.broad_phase import BroadPhase
from armsim_ros.planning.collision_bodies import (
    attached_poses,
    attached_shapes,
    BodyKey,
    fits,
    link_shapes,
    margins,
    must_check,
    padding,
    PlacedShape,
    world_poses,
    world_shapes,
)
from armsim_ros.planning.contacts import BodyType, Contact
from armsim_ros.planning.link_motion import LinkMotion
from armsim_ros.planning.scene import PlanningScene
from armsim_ros.planning.scene_content import SceneContent

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Contacts that are asked of coal for one pair of shapes, to find the deepest.
CONTACTS_OF_A_PAIR = 8


class CollisionChecker:
    """
    Checks robot states in a scene; follows the scene's edits at the next query.

    An edit costs what it changes: a move sets one pose, an edit of the rules or a change of
    the group sets which pairs are looked at, an object that goes is no longer looked at, and
    only an object that is new makes the tables of pairs anew. The robot's own shapes and all
    meshes are prepared once. One thread at a time may use a checker.

    :param scene: the scene to follow; :meth:`use` changes it.
    """

    def __init__(self, scene: PlanningScene) -> None:
        """Take over the robot's shapes and the scene's objects."""
        self._scene = scene
        self._kinematics = scene.kinematic_model
        model = self._kinematics.model
        self._exact = BroadPhase(model)
        self._hull: BroadPhase | None = None
        self._content: SceneContent | None = None
        self._shapes: list[PlacedShape] = []
        self._alive: list[bool] = []
        self._numbers: dict[BodyKey, list[int]] = {}
        self._required: Mask = np.zeros((0, 0), dtype=bool)
        self._group_masks: dict[str | None, Mask] = {}
        self._motion = LinkMotion(self._kinematics, {})
        self._follow()

    @property
    def scene(self) -> PlanningScene:
        """The scene that is followed."""
        return self._scene

    def use(self, scene: PlanningScene) -> None:
        """Follow another scene of the same robot; only what differs is taken over."""
        if scene.kinematic_model is not self._kinematics:
            raise ValueError('a collision checker serves scenes of one kinematic model')
        self._scene = scene

    # ---------------------------------------------------------------- questions

    def in_collision(self, q: Vector, group: str | None = None) -> bool:
        """
        Return whether a state touches anything that it may not touch; exact.

        :param q: (n,) robot state.
        :param group: look only at links that this group moves, and at what they carry.
        :raises PlanningError: INVALID_GROUP_NAME for an unknown group.
        """
        mask = self._mask(group)
        if self._hull is not None:
            self._hull.activate(mask)
            if not self._hull.hit(q):
                return False
        self._exact.activate(mask)
        return self._exact.hit(q)

    def maybe_in_collision(self, q: Vector, group: str | None = None) -> bool:
        """
        Return False only where a state is surely free; meshes of the robot count as hulls.

        Parameters are those of :meth:`in_collision`.
        """
        mask = self._mask(group)
        stage = self._exact if self._hull is None else self._hull
        stage.activate(mask)
        return stage.hit(q)

    def contacts(
        self, q: Vector, group: str | None = None, max_contacts: int | None = None
    ) -> list[Contact]:
        """
        Return the deepest contact of every two bodies that touch, the deepest first.

        Parameters are those of :meth:`in_collision`.

        :param max_contacts: the most to return; None for all.
        """
        self._exact.activate(self._mask(group))
        deepest: dict[tuple[BodyKey, BodyKey], Contact] = {}
        for first, second in self._exact.touching(q):
            contact = self._contact(first, second)
            key = (self._shapes[first].body.key, self._shapes[second].body.key)
            if key not in deepest or contact.depth > deepest[key].depth:
                deepest[key] = contact
        found = sorted(deepest.values(), key=lambda contact: -contact.depth)
        return found if max_contacts is None else found[:max_contacts]

    def distance(self, q: Vector, group: str | None = None) -> float:
        """
        Return the smallest distance [m] of two bodies that may not touch.

        It is negative where they overlap and infinite where no pair is checked; padding is
        taken off. Parameters are those of :meth:`in_collision`.
        """
        self._exact.activate(self._mask(group))
        shapes, content = self._shapes, self._scene.content
        return min(
            (
                distance - padding(shapes[first], shapes[second], content)
                for first, second, distance in self._exact.distances(q)
            ),
            default=math.inf,
        )

    def displacement_bound(self, q1: Vector, q2: Vector, group: str | None = None) -> float:
        """
        Return a distance [m] that no point of robot or load exceeds between two states.

        It holds for every state of the straight segment in joint space.

        :param group: look only at links that this group moves.
        """
        if self._scene.content is not self._content:
            self._follow()
        return self._motion.displacement_bound(q1, q2, group)

    # ---------------------------------------------------------------- following the scene

    def _mask(self, group: str | None) -> Mask:
        if self._scene.content is not self._content:
            self._follow()
        found = self._group_masks.get(group)
        if found is None:
            found = self._group_masks[group] = self._group_mask(group)
        return found

    def _group_mask(self, group: str | None) -> Mask:
        if group is None:
            return self._required.copy()
        self._kinematics.group_indices(group)
        moved = self._kinematics.moved_links(group)
        active = np.array([shape.body.link in moved for shape in self._shapes], dtype=bool)
        mask: Mask = self._required & (active[:, None] | active[None, :])
        return mask

    def _follow(self) -> None:
        """Take over what differs between the content seen last and the scene's."""
        content, before = self._scene.content, self._content
        added: list[PlacedShape] = []
        rules = before is None or content.acm is not before.acm
        if before is None or content.link_scale is not before.link_scale:
            added += self._changed_links(content, before)
        if before is None or content.objects is not before.objects:
            added += self._changed_objects(content, before)
        if before is None or content.attached is not before.attached:
            added += self._changed_attached(content, before)
            self._motion = LinkMotion(self._kinematics, content.attached)
        padded = before is None or content.link_padding is not before.link_padding
        self._content = content
        if added:
            self._add(added, rules)
        elif rules:
            self._require_all()
            self._ensure_pairs()
        if added or rules or not self._group_masks:
            self._group_masks = {}
        if padded and not added:
            for stage in self._stages():
                stage.set_margins(margins(self._shapes, content))

    def _changed_links(
        self, content: SceneContent, before: SceneContent | None
    ) -> list[PlacedShape]:
        added = []
        for link in self._kinematics.robot.links:
            scale = content.link_scale.get(link, 1.0)
            if before is None or scale != before.link_scale.get(link, 1.0):
                self._drop((BodyType.ROBOT_LINK, link))
                added += link_shapes(self._kinematics, link, scale)
        return added

    def _changed_objects(
        self, content: SceneContent, before: SceneContent | None
    ) -> list[PlacedShape]:
        old = {} if before is None else before.objects
        added = []
        for id_ in old:
            if id_ not in content.objects:
                self._drop((BodyType.WORLD_OBJECT, id_))
        for id_, item in content.objects.items():
            was = old.get(id_)
            if was is item:
                continue
            key = (BodyType.WORLD_OBJECT, id_)
            if was is not None and _same_geometry(was.shapes, item.shapes):
                self._place(key, world_poses(item))
            else:
                self._drop(key)
                added += world_shapes(item)
        return added

    def _changed_attached(
        self, content: SceneContent, before: SceneContent | None
    ) -> list[PlacedShape]:
        old = {} if before is None else before.attached
        added = []
        for id_ in old:
            if id_ not in content.attached:
                self._drop((BodyType.ROBOT_ATTACHED, id_))
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
                self._place(key, attached_poses(self._kinematics, item))
            else:
                self._drop(key)
                added += attached_shapes(self._kinematics, item)
        return added

    def _place(self, key: BodyKey, poses: Iterable[Matrix]) -> None:
        for number, pose in zip(self._numbers[key], poses, strict=True):
            for stage in self._stages():
                stage.place(number, pose)
            shape = self._shapes[number]
            self._shapes[number] = PlacedShape(
                shape.body, shape.joint, pose, shape.exact, shape.hull, shape.against
            )

    def _drop(self, key: BodyKey) -> None:
        for number in self._numbers.pop(key, ()):
            self._alive[number] = False
            self._required[number, :] = False
            self._required[:, number] = False
            self._group_masks = {}

    # ---------------------------------------------------------------- tables

    def _stages(self) -> list[BroadPhase]:
        return [self._exact] if self._hull is None else [self._exact, self._hull]

    def _add(self, added: list[PlacedShape], rules: bool) -> None:
        kept = len(self._shapes)
        if self._alive.count(False) > 16 + self._alive.count(True):
            self._compact()
            kept = 0
        start = len(self._shapes)
        for shape in added:
            self._numbers.setdefault(shape.body.key, []).append(len(self._shapes))
            self._shapes.append(shape)
            self._alive.append(True)
        grown = np.zeros((len(self._shapes), len(self._shapes)), dtype=bool)
        grown[:start, :start] = self._required
        self._required = grown
        if rules:
            self._require_all()
        else:
            self._require(range(start, len(self._shapes)))
        self._rebuild(kept)

    def _compact(self) -> None:
        """Forget the shapes that are no longer looked at."""
        alive = np.flatnonzero(self._alive)
        self._required = self._required[np.ix_(alive, alive)].copy()
        self._shapes = [self._shapes[number] for number in alive]
        self._alive = [True] * len(alive)
        self._numbers = {}
        for number, shape in enumerate(self._shapes):
            self._numbers.setdefault(shape.body.key, []).append(number)

    def _require_all(self) -> None:
        self._required[:] = False
        self._require(range(len(self._shapes)))

    def _require(self, numbers: Iterable[int]) -> None:
        """Find the pairs to check of the given shapes with all shapes before them."""
        acm = self._scene.content.acm if self._content is None else self._content.acm
        known: dict[tuple[BodyKey, BodyKey], bool] = {}
        shapes = self._shapes
        robot = [i for i, s in enumerate(shapes) if self._alive[i] and s.body.link]
        everything = [i for i in range(len(shapes)) if self._alive[i]]
        for second in numbers:
            if not self._alive[second]:
                continue
            other = shapes[second]
            for first in everything if other.body.link else robot:
                one = shapes[first]
                if first >= second and (one.body.link and other.body.link):
                    continue
                key = (one.body.key, other.body.key)
                check = known.get(key)
                if check is None:
                    check = known[key] = must_check(one.body, other.body, acm)
                if check and fits(one, other):
                    self._required[min(first, second), max(first, second)] = True

    def _ensure_pairs(self) -> None:
        """Make the tables of pairs anew where a pair is required that they do not have."""
        if bool((self._required & ~self._exact.pairs).any()):
            self._rebuild(len(self._shapes))

    def _rebuild(self, kept: int) -> None:
        content = self._scene.content if self._content is None else self._content
        pairs = self._required.copy()
        distances = margins(self._shapes, content)
        self._exact.rebuild(
            [(s.joint, s.pose, s.exact) for s in self._shapes], pairs, distances, keep=kept
        )
        meshes = any(s.hull is not s.exact for s in self._shapes)
        if not meshes:
            self._hull = None
            return
        if self._hull is None:
            self._hull = BroadPhase(self._kinematics.model)
            kept = 0
        self._hull.rebuild(
            [(s.joint, s.pose, s.hull) for s in self._shapes], pairs, distances, keep=kept
        )

    # ---------------------------------------------------------------- contacts

    def _contact(self, first: int, second: int) -> Contact:
        one, other = self._shapes[first], self._shapes[second]
        content = self._scene.content
        margin = padding(one, other, content)
        request = coal.CollisionRequest()
        request.enable_contact = True
        request.num_max_contacts = CONTACTS_OF_A_PAIR
        request.security_margin = margin
        result = coal.CollisionResult()
        shape_1, pose_1 = self._exact.shape(first)
        shape_2, pose_2 = self._exact.shape(second)
        coal.collide(shape_1, _transform(pose_1), shape_2, _transform(pose_2), request, result)
        best = min(
            result.getContacts(), key=lambda contact: contact.penetration_depth, default=None
        )
        if best is None:  # the two just graze each other, and this time did not
            position, normal, depth = np.array(pose_1.translation), np.zeros(3), 0.0
        else:
            position = np.array(best.pos, dtype=np.float64).reshape(3)
            normal = np.array(best.normal, dtype=np.float64).reshape(3)
            depth = margin - float(best.penetration_depth)
        return Contact(
            one.body.name,
            other.body.name,
            one.body.type,
            other.body.type,
            position,
            normal,
            depth,
        )


def _same_geometry(before: Iterable[Any], after: Iterable[Any]) -> bool:
    first, second = tuple(before), tuple(after)
    return len(first) == len(second) and all(
        one.geometry is other.geometry for one, other in zip(first, second, strict=True)
    )


def _transform(pose: Any) -> Any:
    return coal.Transform3s(pose.rotation, pose.translation)


__all__ = ['BodyType', 'CollisionChecker', 'Contact']
