# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The shapes of a scene, and the tables of pairs that collision checks need."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any

import coal
import numpy as np

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.planning.budget import Poll, POLLED_STATES
from armsim_ros.planning.collision.bodies import (
    BodyKey,
    margins,
    padding,
    PlacedShape,
    required_pairs,
)
from armsim_ros.planning.collision.broad_phase import BroadPhase
from armsim_ros.planning.scene.content import SceneContent

#: Contacts that are asked of coal for one pair of shapes, to find the deepest.
CONTACTS_OF_A_PAIR = 8


class CollisionTables:
    """
    Numbered shapes, which pairs of them are required, and the broad phases over them.

    Made once for its shapes and for the rules; only poses and padding can be set after that.

    :param kinematics: the robot.
    :param carried: the shapes of the robot and of what it carries.
    :param standing: shapes of the world.
    :param content: whose rules and padding hold.
    :param among: whether the carried shapes are checked against each other as well.
    """

    def __init__(
        self, kinematics: KinematicModel, carried: Sequence[PlacedShape],
        standing: Sequence[PlacedShape], content: SceneContent, *, among: bool,
    ) -> None:
        self._kinematics = kinematics
        self._content = content
        self.shapes = [*carried, *standing]
        self._numbers: dict[BodyKey, list[int]] = {}
        for number, shape in enumerate(self.shapes):
            self._numbers.setdefault(shape.body.key, []).append(number)
        self._required = required_pairs(carried, standing, content.acm, among=among)
        self._joints = np.array([shape.joint for shape in self.shapes], dtype=np.intp)
        self._group_masks: dict[str | None, Mask] = {}
        self._rigid_hits: dict[str | None, bool] = {}
        self._margins = {0.0: margins(self.shapes, content)}
        self.exact = BroadPhase(
            kinematics.model, [(s.joint, s.pose, s.exact) for s in self.shapes], self._required,
            self._margins[0.0],
        )
        #: With the robot's meshes as hulls; None where it has no meshes.
        self.hull: BroadPhase | None = None
        if any(shape.hull is not shape.exact for shape in self.shapes):
            self.hull = BroadPhase(
                kinematics.model, [(s.joint, s.pose, s.hull) for s in self.shapes],
                self._required, self._margins[0.0],
            )

    def mask(self, group: str | None) -> Mask:
        """
        Return the pairs (g, g) to check for a group, None for all links.

        :raises PlanningError: INVALID_GROUP_NAME.
        """
        found = self._group_masks.get(group)
        if found is None:
            found = self._group_masks[group] = self._group_mask(group)
        return found

    def _group_mask(self, group: str | None) -> Mask:
        if group is None:
            return self._required.copy()
        self._kinematics.group_indices(group)
        moved = self._kinematics.moved_links(group)
        active = np.array([shape.body.link in moved for shape in self.shapes], dtype=bool)
        mask: Mask = self._required & (active[:, None] | active[None, :])
        return mask

    # ---------------------------------------------------------------- edits

    def set_padding(self, content: SceneContent) -> None:
        """Take over the padding of a content."""
        self._content = content
        self._margins = {0.0: margins(self.shapes, content)}
        self._rigid_hits = {}

    def place(self, key: BodyKey, poses: Iterable[Matrix]) -> None:
        """Move the shapes of a body to other poses (4, 4) on their joint."""
        for number, pose in zip(self._numbers[key], poses, strict=True):
            for stage in (self.exact, self.hull):
                if stage is not None:
                    stage.place(number, pose)
            self.shapes[number] = replace(self.shapes[number], pose=pose)
        self._rigid_hits = {}

    # ---------------------------------------------------------------- questions

    def ready(self, exact: bool, group: str | None, clearance: float = 0.0) -> BroadPhase:
        """
        Return a stage that looks at a group's pairs.

        :param exact: the shapes themselves; else hulls, which are never wrong about a state
            that they call free.
        :param clearance: [m] nearer than this counts as touching.
        """
        stage = self.exact if exact or self.hull is None else self.hull
        found = self._margins.get(clearance)
        if found is None:
            found = self._margins[clearance] = self._margins[0.0] + clearance
        stage.activate(self.mask(group))
        stage.set_margins(found)
        return stage

    def judge(
        self, group: str | None, clearance: float, exact: bool
    ) -> Callable[[Vector], bool]:
        """
        Return the quickest form of the question whether states touch, rigid pairs aside.

        It holds until another question or an edit. Parameters are those of :meth:`ready`.
        """
        maybe = self.ready(False, group, clearance).judge()
        if not exact or self.hull is None:
            return maybe
        surely = self.ready(True, group, clearance).judge()
        return lambda q: maybe(q) and surely(q)

    def near(
        self, states: Matrix, reach: Matrix, relative: Matrix, group: str | None, exact: bool,
        clearance: float, poll: Poll,
    ) -> Mask:
        """
        Return in which states a pair of shapes may come into touch within reach.

        :param states: (k, n) robot states.
        :param reach: (k, n) motion of every joint [rad or m].
        :param relative: (joints, joints, n) motion of what one joint carries against what
            another one does [m/rad or m/m], 0 for the world.
        :param exact: judge by the shapes themselves, not by hulls.
        :param clearance: [m] that shall be left.
        :param poll: called now and then; raises what ends the request.
        """
        count = len(self.shapes)
        if not count:
            return np.zeros(len(states), dtype=bool)
        stage = self.ready(exact, group)
        hit = stage.judge()
        weights = relative[self._joints[:, None], self._joints].reshape(count * count, -1).T
        kept = self._margins[0.0] + clearance
        found = np.zeros(len(states), dtype=bool)
        for begin in range(0, len(states), POLLED_STATES[exact]):
            poll()
            part = slice(begin, begin + POLLED_STATES[exact])
            margins = (reach[part] @ weights).reshape(-1, count, count) + kept
            for k, margin in enumerate(margins, begin):
                stage.set_margins(margin)
                found[k] = hit(states[k])
        return found

    def touched(
        self, states: Matrix, group: str | None, clearance: float, poll: Poll
    ) -> Mask:
        """Return in which states (k, n) hulls touch; parameters are those of :meth:`near`."""
        hit = self.ready(False, group, clearance).judge()
        found = np.zeros(len(states), dtype=bool)
        for k, q in enumerate(states):
            if k % POLLED_STATES[False] == 0:
                poll()
            found[k] = hit(q)
        return found

    def rigid_hit(self, group: str | None) -> bool:
        """
        Return whether two shapes touch that no joint moves against each other.

        The manager leaves those out; the answer holds until the next edit.
        """
        found = self._rigid_hits.get(group)
        if found is None:
            joints = np.array([shape.joint for shape in self.shapes])
            pairs = np.argwhere(self.mask(group) & (joints[:, None] == joints[None, :]))
            found = any(
                self.collide(int(i), int(j), self.shapes[i].pose, self.shapes[j].pose)
                .isCollision()
                for i, j in pairs
            )
            self._rigid_hits[group] = found
        return found

    # ---------------------------------------------------------------- two shapes

    def margin(self, first: int, second: int) -> float:
        """Return the distance [m] at which two shapes count as touching."""
        return padding(self.shapes[first], self.shapes[second], self._content)

    def collide(self, first: int, second: int, pose_1: Matrix, pose_2: Matrix) -> Any:
        """Return coal's result for two shapes at poses (4, 4) in a common frame."""
        request = coal.CollisionRequest()
        request.enable_contact = True
        request.num_max_contacts = CONTACTS_OF_A_PAIR
        request.security_margin = self.margin(first, second)
        result = coal.CollisionResult()
        coal.collide(
            self.shapes[first].exact,
            coal.Transform3s(pose_1[:3, :3], pose_1[:3, 3]),
            self.shapes[second].exact,
            coal.Transform3s(pose_2[:3, :3], pose_2[:3, 3]),
            request,
            result,
        )
        return result
