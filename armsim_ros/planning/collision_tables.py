# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The shapes of a scene, and the tables of pairs that collision checks need."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Set
from typing import Any

import coal
import numpy as np
from numpy.typing import NDArray

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.planning.broad_phase import BroadPhase
from armsim_ros.planning.collision_bodies import (
    BodyKey,
    fits,
    margins,
    must_check,
    padding,
    PlacedShape,
)
from armsim_ros.planning.poll import Poll, POLLED_STATES
from armsim_ros.planning.scene_content import SceneContent

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Contacts that are asked of coal for one pair of shapes, to find the deepest.
CONTACTS_OF_A_PAIR = 8
#: Shapes that are no longer looked at, and yet cost time with every check.
MOST_DROPPED = 3


class CollisionTables:
    """
    Numbered shapes, which pairs of them are required, and the broad phases over them.

    A shape that is dropped keeps its number and is no longer looked at, until enough of them
    are gone; so only a shape that is new makes the tables of pairs anew.

    :param kinematics: the robot.
    :param content: whose rules and padding hold.
    """

    def __init__(self, kinematics: KinematicModel, content: SceneContent) -> None:
        """Begin without shapes."""
        self._kinematics = kinematics
        self._content = content
        self.exact = BroadPhase(kinematics.model)
        #: With the robot's meshes as hulls; None where it has no meshes.
        self.hull: BroadPhase | None = None
        self.shapes: list[PlacedShape] = []
        self._alive: list[bool] = []
        #: How many of the shapes the broad phases have under the same number.
        self._kept = 0
        self._numbers: dict[BodyKey, list[int]] = {}
        self._required: Mask = np.zeros((0, 0), dtype=bool)
        self._group_masks: dict[str | None, Mask] = {}
        self._rigid_hits: dict[str | None, bool] = {}
        self._margins: dict[float, Matrix] = {}
        self._joints: NDArray[np.intp] = np.zeros(0, dtype=np.intp)

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

    def renew(
        self,
        added: list[PlacedShape],
        content: SceneContent,
        *,
        rules: Set[str] | None,
        padded: bool,
    ) -> None:
        """
        Take over new shapes, and rules and padding that changed.

        :param content: whose rules and padding hold from now on.
        :param rules: names whose entries in the allowed collision matrix are others; None for
            all.
        :param padded: whether the padding is another one.
        """
        self._content = content
        self._rigid_hits = {}
        if added:
            self._add(added)
        if rules is None or rules:
            self._require_anew(rules)
        if added:
            self._rebuild()
        elif rules is None or rules:
            self._ensure_pairs()
        if added or rules is None or rules:
            self._group_masks = {}
        if padded and not added:
            for stage in self._stages():
                stage.set_margins(self._padding())

    def place(self, key: BodyKey, poses: Iterable[Matrix]) -> None:
        """Move the shapes of a body to other poses (4, 4) on their joint."""
        for number, pose in zip(self._numbers[key], poses, strict=True):
            for stage in self._stages():
                stage.place(number, pose)
            shape = self.shapes[number]
            self.shapes[number] = PlacedShape(
                shape.body, shape.joint, pose, shape.exact, shape.hull, shape.against
            )

    def drop(self, key: BodyKey) -> None:
        """Look no longer at the shapes of a body."""
        for number in self._numbers.pop(key, ()):
            self._alive[number] = False
            self._required[number, :] = False
            self._required[:, number] = False
            self._group_masks = {}

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
        stage = self.ready(exact, group)
        hit = stage.judge()
        count = len(self.shapes)
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


    # ---------------------------------------------------------------- pairs

    def _padding(self) -> Matrix:
        padding = margins(self.shapes, self._content)
        self._margins = {0.0: padding}
        return padding

    def _stages(self) -> list[BroadPhase]:
        return [self.exact] if self.hull is None else [self.exact, self.hull]

    def _add(self, added: list[PlacedShape]) -> None:
        if self._alive.count(False) > MOST_DROPPED:
            self._compact()
        start = len(self.shapes)
        for shape in added:
            self._numbers.setdefault(shape.body.key, []).append(len(self.shapes))
            self.shapes.append(shape)
            self._alive.append(True)
        grown = np.zeros((len(self.shapes), len(self.shapes)), dtype=bool)
        grown[:start, :start] = self._required
        self._required = grown
        self._require(range(start, len(self.shapes)))

    def _compact(self) -> None:
        """Forget the shapes that are no longer looked at."""
        alive = np.flatnonzero(self._alive)
        self._required = self._required[np.ix_(alive, alive)].copy()
        self.shapes = [self.shapes[number] for number in alive]
        self._alive = [True] * len(alive)
        self._kept = 0
        self._numbers = {}
        for number, shape in enumerate(self.shapes):
            self._numbers.setdefault(shape.body.key, []).append(number)

    def _require_anew(self, names: Set[str] | None) -> None:
        """Find the pairs to check of shapes whose rules are others; None for all."""
        numbers = [
            number for number, shape in enumerate(self.shapes)
            if names is None or shape.body.name in names
        ]
        self._required[numbers, :] = False
        self._required[:, numbers] = False
        self._require(numbers)

    def _require(self, numbers: Collection[int]) -> None:
        """Find the pairs to check of the given shapes with all."""
        acm = self._content.acm
        known: dict[tuple[BodyKey, BodyKey], bool] = {}
        shapes = self.shapes
        given = set(numbers)
        robot = [i for i, s in enumerate(shapes) if self._alive[i] and s.body.link]
        everything = [i for i in range(len(shapes)) if self._alive[i]]
        for second in numbers:
            if not self._alive[second]:
                continue
            other = shapes[second]
            for first in everything if other.body.link else robot:
                if first >= second and first in given:
                    continue
                one = shapes[first]
                key = (one.body.key, other.body.key)
                check = known.get(key)
                if check is None:
                    check = known[key] = must_check(one.body, other.body, acm)
                if check and fits(one, other):
                    self._required[min(first, second), max(first, second)] = True

    def _ensure_pairs(self) -> None:
        """Make the tables of pairs anew where a pair is required that they do not have."""
        if bool((self._required & ~self.exact.pairs).any()):
            self._rebuild()

    def _rebuild(self) -> None:
        kept, self._kept = self._kept, len(self.shapes)
        self._joints = np.array([shape.joint for shape in self.shapes], dtype=np.intp)
        pairs = self._required.copy()
        distances = self._padding()
        self.exact.rebuild(
            [(s.joint, s.pose, s.exact) for s in self.shapes], pairs, distances, keep=kept
        )
        meshes = any(s.hull is not s.exact for s in self.shapes)
        if not meshes:
            self.hull = None
            return
        if self.hull is None:
            self.hull = BroadPhase(self._kinematics.model)
            kept = 0
        self.hull.rebuild(
            [(s.joint, s.pose, s.hull) for s in self.shapes], pairs, distances, keep=kept
        )


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
