# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Collision tables: which pairs of shapes must not touch, and the broad phases over them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.planning.budget import nothing, Poll, POLLED_STATES
from armsim_ros.planning.collision.bodies import BodyKey, margins, PlacedShape, required_pairs
from armsim_ros.planning.collision.broad_phase import BroadPhase, CollisionTest
from armsim_ros.planning.collision.contact_query import ContactDistances, within_margins
from armsim_ros.planning.collision.near_pairs import Exactly
from armsim_ros.planning.scene.content import SceneContent


class CollisionTables:
    """
    Numbered shapes, which pairs of them are required, and the broad phases over them.

    Made once for its shapes and for the rules; only poses can be set after that.

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
        self.shapes = [*carried, *standing]
        self._numbers: dict[BodyKey, list[int]] = {}
        for number, shape in enumerate(self.shapes):
            self._numbers.setdefault(shape.body.key, []).append(number)
        self._required = required_pairs(carried, standing, content.acm, among=among)
        self._joints = np.array([shape.joint for shape in self.shapes], dtype=np.intp)
        self._group_masks: dict[str | None, Mask] = {}
        self._rigid_pairs: dict[str | None, list[int]] = {}
        self._margins = margins(self.shapes, content)
        self._distances = ContactDistances([shape.exact for shape in self.shapes])
        within = self._within = self._distances.within(self._margins)
        #: Clearance [m] -> distances (g, g) [m] that count as contact.
        self._kept: dict[float, Matrix] = {0.0: within}
        self.exact = BroadPhase(
            kinematics.model, [(s.joint, s.pose, s.exact) for s in self.shapes], self._required,
            within,
        )
        #: With the robot's meshes as hulls; None where it has no meshes.
        self.hull: BroadPhase | None = None
        if any(shape.hull is not shape.exact for shape in self.shapes):
            self.hull = BroadPhase(
                kinematics.model, [(s.joint, s.pose, s.hull) for s in self.shapes],
                self._required, within,
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

    def place(self, key: BodyKey, shapes: Sequence[PlacedShape]) -> None:
        """Take over the shapes of a body, which have moved on their joint."""
        for number, shape in zip(self._numbers.get(key, ()), shapes, strict=False):
            for stage in (self.exact, self.hull):
                if stage is not None:
                    stage.place(number, shape.pose)
            self.shapes[number] = shape
            self._rigid_pairs = {}

    # ---------------------------------------------------------------- questions

    def ready(self, exact: bool, group: str | None, clearance: float = 0.0) -> BroadPhase:
        """
        Return a stage that checks a group's pairs.

        :param exact: the shapes themselves; else hulls, which are never wrong about a state
            that they call free.
        :param clearance: [m] nearer than this counts as touching.
        """
        stage = self.exact if exact or self.hull is None else self.hull
        found = self._kept.get(clearance)
        if found is None:
            found = self._kept[clearance] = self._distances.within(
                self._margins + clearance)
        stage.activate(self.mask(group))
        stage.set_margins(found)
        return stage

    def test(self, group: str | None, clearance: float, exact: bool) -> CollisionTest:
        """
        Return the quickest form of the question whether states touch, rigid pairs aside.

        It holds until another question or an edit. Parameters are those of :meth:`ready`.
        """
        maybe = self.ready(False, group, clearance).test()
        if not exact or self.hull is None:
            return maybe
        surely = self.hull.confirmed(self.ready(True, group, clearance))
        return lambda q: maybe(q) and bool(surely(q))

    def touching(self, group: str | None, q: Vector) -> list[int]:
        """Return all pairs that touch in a state; :attr:`exact` has their poses."""
        hull, exact = self.ready(False, group), self.ready(True, group)
        rigid = self.rigid_pairs(group)
        if not hull.test()(q) and not rigid:
            return []
        return [*rigid, *sorted(hull.confirmed(exact, every=True)(q))]

    def near(
        self, states: Matrix, moved: Matrix | None, group: str | None, exact: Exactly,
        clearance: float, poll: Poll, before: Mask | tuple[Matrix, Matrix],
    ) -> Mask:
        """
        Return which pairs (k, pairs) may come into touch with so much motion.

        :param states: (k, n) robot states.
        :param moved: (k, joints, joints) motion of what a joint carries against what another
            joint does [m], 0 for the world; None for none.
        :param exact: when to check the shapes themselves.
        :param clearance: [m] that shall be left.
        :param poll: called now and then; raises what ends the request.
        :param before: (k, pairs) all that are possible; or rotations (k, joints, 3, 3) and
            origins (k, joints, 3) of the joints, to find these.
        """
        hull = self.ready(False, group, clearance)
        first, second = hull.pairs
        kept = self._margins[first, second] + clearance
        least = self._distances.least[first, second]
        touching = within_margins(kept, least)
        within = np.broadcast_to(touching, (len(states), len(first))) if moved is None else (
            within_margins(moved[:, self._joints[first], self._joints[second]] + kept, least))
        possible = hull.boxes_near(*before, within) if isinstance(before, tuple) else before
        near = hull.touching(states, possible, within, poll, POLLED_STATES[False])
        if exact is Exactly.NEVER or self.hull is None:
            return near
        asked = near
        if exact is Exactly.WHERE_HULLS_TOUCH:
            asked = hull.touching(
                states, near, np.broadcast_to(touching, within.shape), poll, POLLED_STATES[False])
        shapes = self.ready(True, group, clearance)
        surely = shapes.touching(states, asked, within, poll, POLLED_STATES[True])
        found: Mask = (near & ~asked) | surely
        return found

    def rigid_pairs(self, group: str | None) -> list[int]:
        """
        Return the pairs that touch and that no joint moves against each other.

        The manager leaves those out; the answer holds until the next edit.
        """
        found = self._rigid_pairs.get(group)
        if found is None:
            found = self._rigid_pairs[group] = []
            asked = self.mask(group) & (self._joints[:, None] == self._joints)
            if asked.any():
                exact = self.ready(True, group)
                touching = exact.touching(
                    np.zeros((1, self._kinematics.n)), asked[exact.pairs][None],
                    self._within[exact.pairs][None], nothing, 1)
                found += np.flatnonzero(touching).tolist()
        return found

    # ---------------------------------------------------------------- two shapes

    def margin(self, first: int, second: int) -> float:
        """Return the distance [m] at which two shapes count as touching."""
        return float(self._margins[first, second])

    def apart(self, first: int, second: int, distance: float) -> float:
        """Return a distance found [m] without the padding; not positive where they touch."""
        left = distance - self.margin(first, second)
        return left if distance > self._within[first, second] else min(left, 0.0)
