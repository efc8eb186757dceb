# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Collision tables: which pairs of shapes must not touch, and the broad phases over them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import coal
import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.planning.budget import Poll, POLLED_STATES
from armsim_ros.planning.collision.bodies import (
    BodyKey,
    margins,
    PlacedShape,
    required_pairs,
)
from armsim_ros.planning.collision.contact_query import (
    contact_request,
    ContactDistances,
    PlaneDistance,
)
from armsim_ros.planning.scene.content import SceneContent

CollisionTest = Callable[[Vector], bool]
"""Tests whether a robot state (n,) touches anything."""


_NOT_CONVEX = (coal.BVHModelBase, coal.OcTree, coal.Plane)


class BroadPhase:
    """
    A set of placed shapes and the pairs of them that are checked.

    Owns Pinocchio's geometry model, its data and the broad phase manager together, because the
    manager and the data hold bare pointers into the model. The manager is coal's naive manager
    behind Pinocchio's tree: measured against plain pairwise checks the array-based trees and
    sweep and prune lose collisions, and the naive manager is the fastest of those that do not.
    Like all of Pinocchio's managers it leaves out pairs of shapes on the same joint.

    :param model: Pinocchio's kinematic model; also kept alive by its owner.
    :param shapes: (joint, pose (4, 4) on it, coal shape) each.
    :param pairs: (g, g) upper triangle, the pairs that can be checked.
    :param margins: (g, g) [m] distance that counts as contact, at least the tolerances.
    """

    def __init__(
        self, model: Any, shapes: Sequence[tuple[int, Matrix, Any]], pairs: Mask,
        margins: Matrix,
    ) -> None:
        self._model = model
        self._shapes = list(shapes)
        self._pairs = pairs
        self._margins = margins
        self._active: Mask | None = None
        #: (pairs,) which of them are active.
        self._looked_at = np.zeros(0, dtype=bool)
        self._geometry: Any = None
        self._geometry_data: Any = None
        self._manager: Any = None
        #: Hears of the pairs that the manager cannot rule out; stops at the first that touches.
        self._first_touch: Any = None
        self._data: Any = None
        self._spheres: tuple[list[int], NDArray[np.intp], Matrix] | None = None
        #: (pairs,) sums of the radii of the spheres around two shapes [m].
        self._radii = np.zeros(0)
        self._pair_table = np.zeros((0, 2), dtype=np.intp)
        #: Numbers of a mesh and a plane -> their distance.
        self._planes: dict[tuple[int, ...], PlaneDistance] = {}

    def _build(self) -> None:
        """Build the tables; done at the first question, so as not to do it in vain."""
        self._data = self._model.createData()
        self._geometry = pin.GeometryModel()
        for number, (joint, pose, shape) in enumerate(self._shapes):
            self._geometry.addGeometryObject(
                pin.GeometryObject(str(number), joint, pin.SE3(pose), shape)
            )
        self._geometry.setCollisionPairs(self._pairs)
        self._geometry_data = pin.GeometryData(self._geometry)
        # Pinocchio has GJK begin where it ended the last time. From far away it then loses
        # contacts, such as that of two boxes about a common centre.
        plain, guessing = contact_request(False), contact_request(True)
        for k, pair in enumerate(self._geometry.collisionPairs):
            convex = not any(isinstance(self._shapes[number][2], _NOT_CONVEX)
                             for number in (pair.first, pair.second))
            self._geometry_data.collisionRequests[k] = guessing if convex else plain
            self._geometry_data.distanceRequests[k] = coal.DistanceRequest()
        self._manager = pin.TreeBroadPhaseManager_NaiveCollisionManager(
            self._model, self._geometry, self._geometry_data
        )
        self._first_touch = pin.CollisionCallBackDefault(
            self._geometry, self._geometry_data, True)
        self._geometry_data.setSecurityMargins(self._geometry, self._margins)

    def set_margins(self, margins: Matrix) -> None:
        """Set the distance [m] below which a pair (g, g) counts as touching."""
        if margins is not self._margins:
            self._margins = margins
            if self._manager is not None:
                self._geometry_data.setSecurityMargins(self._geometry, margins)

    def place(self, number: int, pose: Matrix) -> None:
        """Move a shape to another pose (4, 4) on its joint."""
        joint, _, shape = self._shapes[number]
        self._shapes[number] = joint, pose, shape
        self._spheres = None
        if self._manager is not None:
            self._geometry.geometryObjects[number].placement = pin.SE3(pose)

    def activate(self, active: Mask) -> None:
        """Check these pairs (g, g) only, of those that can be checked."""
        if self._manager is None:
            self._build()
        if active is not self._active:
            self._geometry_data.setActiveCollisionPairs(self._geometry, active)
            self._looked_at = np.array(self._geometry_data.activeCollisionPairs, dtype=bool)
            self._active = active

    def test(self) -> CollisionTest:
        """Return whether any active pair touches, as a question of use until the shapes change."""
        place, update, collide = (
            pin.updateGeometryPlacements, self._manager.update, self._manager.collide)
        of_state = self._model, self._data, self._geometry, self._geometry_data
        first_touch = self._first_touch

        def touches(q: Vector) -> bool:
            place(*of_state, q)
            update(False)
            collide(first_touch)
            return bool(first_touch.collision)

        return touches

    def confirmed(self, exact: BroadPhase, every: bool = False) -> Callable[[Vector], list[int]]:
        """
        Return a function that finds the pairs of the last test that touch on exact shapes, too.

        Only pairs that touch here are checked exactly, and the pair that the last test has found
        comes first. Pairs of shapes on the same joint are left out.

        :param exact: the same pairs of other shapes, inside these; or this object itself.
        :param every: find all numbers of pairs, not only the first.
        """
        place, collide, touches = (
            pin.updateGeometryPlacements, self._manager.collide, pin.computeCollision)
        of_state = exact._model, exact._data, exact._geometry, exact._geometry_data
        geometry, data = exact._geometry, exact._geometry_data
        first_touch, active = self._first_touch, self._geometry_data

        def confirmed(q: Vector) -> list[int]:
            place(*of_state, q)
            found, passed = [], []
            try:
                while first_touch.collision:
                    pair = first_touch.collisionPairIndex
                    if touches(geometry, data, pair):
                        found.append(pair)
                        if not every:
                            break
                    active.deactivateCollisionPair(pair)
                    passed.append(pair)
                    collide(first_touch)
            finally:
                for pair in passed:
                    active.activateCollisionPair(pair)
            return found

        return confirmed

    def numbers(self, pair: int) -> tuple[int, int]:
        """Return the numbers of a pair's shapes."""
        found = self._geometry.collisionPairs[pair]
        return found.first, found.second

    def near(self, q: Vector, within: float) -> list[tuple[int, int, float]]:
        """
        Return (first, second, distance [m]) of the active pairs nearer than ``within`` [m].

        What spheres around the shapes show to be farther apart is not measured.
        """
        geometry, data = self._geometry, self._geometry_data
        pin.updateGeometryPlacements(self._model, self._data, geometry, data, q)
        if self._spheres is None:
            self._spheres = self._bound_shapes()
        joints, places, centres = self._spheres
        poses = np.array([self._data.oMi[joint].homogeneous for joint in joints])
        centres = (poses.reshape(-1, 4, 4)[places] @ centres)[:, :3, 0]
        first, second = self._pair_table.T
        ways = centres[first] - centres[second]
        apart = np.einsum('ij,ij->i', ways, ways) < (self._radii + within) ** 2
        found = []
        for k in np.flatnonzero(self._looked_at & apart):
            distance = self._distance(int(k))
            if distance < within:
                found.append((int(first[k]), int(second[k]), distance))
        return found

    def _distance(self, number: int) -> float:
        """Return the distance [m] of a pair where the shapes were placed last."""
        places = tuple(int(place) for place in self._pair_table[number])
        kinds = [self._shapes[place][2].getNodeType() for place in places]
        if coal.NODE_TYPE.GEOM_PLANE in kinds and coal.NODE_TYPE.BV_OBBRSS in kinds:
            mesh, plane = sorted(
                places, key=lambda place: isinstance(self._shapes[place][2], coal.Plane))
            if places not in self._planes:
                self._planes[places] = PlaneDistance(
                    self._shapes[mesh][2], self._shapes[plane][2])
            return self._planes[places].between(self.pose(mesh), self.pose(plane))
        return float(pin.computeDistance(
            self._geometry, self._geometry_data, number).min_distance)

    def _bound_shapes(self) -> tuple[list[int], NDArray[np.intp], Matrix]:
        """
        Put a sphere around each of g shapes, and note the pairs of shapes.

        :returns: the joints that carry shapes, which of those carries each shape (g,), and the
            centres (g, 4, 1) of the spheres on them.
        """
        pairs = [(pair.first, pair.second) for pair in self._geometry.collisionPairs]
        self._pair_table = np.array(pairs, dtype=np.intp).reshape(-1, 2)
        centres, radii = np.ones((len(self._shapes), 4, 1)), np.zeros(len(self._shapes))
        for number, (_, pose, shape) in enumerate(self._shapes):
            shape.computeLocalAABB()
            centres[number, :3, 0] = pose[:3, :3] @ shape.aabb_center + pose[:3, 3]
            radii[number] = shape.aabb_radius
        self._radii = radii[self._pair_table].sum(axis=1)
        joints, places = np.unique([joint for joint, _, _ in self._shapes], return_inverse=True)
        return [int(joint) for joint in joints], places, centres

    def pose(self, number: int) -> Matrix:
        """Return a shape's pose (4, 4) in the model frame at the last query."""
        pose: Matrix = self._geometry_data.oMg[number].homogeneous
        return pose


#: Contacts that are asked of coal for one pair of shapes, to find the deepest.
CONTACTS_OF_A_PAIR = 8


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
        self._rigid_pairs: dict[str | None, list[tuple[int, int]]] = {}
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

    def touching(self, group: str | None, q: Vector) -> list[tuple[int, int]]:
        """Return all pairs of shapes that touch in a state; :attr:`exact` has their poses."""
        hull, exact = self.ready(False, group), self.ready(True, group)
        rigid = self.rigid_pairs(group)
        if not hull.test()(q) and not rigid:
            return []
        moving = hull.confirmed(exact, every=True)(q)
        return [*rigid, *(exact.numbers(pair) for pair in sorted(moving))]

    def near(
        self, states: Matrix, reach: Matrix | None, relative: Matrix, group: str | None,
        exact: bool, clearance: float, poll: Poll,
    ) -> Mask:
        """
        Return in which states a pair of shapes may come into touch within reach.

        :param states: (k, n) robot states.
        :param reach: (k, n) motion of every joint [rad or m]; None for none.
        :param relative: (joints, joints, n) motion of what a joint carries against what
            another joint does [m/rad or m/m], 0 for the world.
        :param exact: check the shapes themselves, not by hulls.
        :param clearance: [m] that shall be left.
        :param poll: called now and then; raises what ends the request.
        """
        found = np.zeros(len(states), dtype=bool)
        count = len(self.shapes)
        if not count:
            return found
        hit = self.test(group, clearance, exact)
        hull = self.hull or self.exact
        stages = (hull, self.exact) if exact and self.hull is not None else (hull,)
        few = POLLED_STATES[False]
        weights = relative[self._joints[:, None], self._joints].reshape(count * count, -1).T
        kept = self._margins + clearance
        for begin in range(0, len(states), few):
            part = slice(begin, begin + few)
            margins = None if reach is None else self._distances.within(
                (reach[part] @ weights).reshape(-1, count, count) + kept)
            for k, q in enumerate(states[part]):
                if k % POLLED_STATES[exact] == 0:
                    poll()
                if margins is not None:
                    for stage in stages:
                        stage.set_margins(margins[k])
                found[begin + k] = hit(q)
        return found

    def rigid_pairs(self, group: str | None) -> list[tuple[int, int]]:
        """
        Return the pairs of shapes that touch and that no joint moves against each other.

        The manager leaves those out; the answer holds until the next edit.
        """
        found = self._rigid_pairs.get(group)
        if found is None:
            joints = self._joints
            pairs = np.argwhere(self.mask(group) & (joints[:, None] == joints[None, :]))
            found = self._rigid_pairs[group] = [
                (int(i), int(j)) for i, j in pairs
                if self.collide(int(i), int(j), self.shapes[i].pose, self.shapes[j].pose)
                .isCollision()]
        return found

    # ---------------------------------------------------------------- two shapes

    def margin(self, first: int, second: int) -> float:
        """Return the distance [m] at which two shapes count as touching."""
        return float(self._margins[first, second])

    def apart(self, first: int, second: int, distance: float) -> float:
        """Return a distance found [m] without the padding; not positive where they touch."""
        left = distance - self.margin(first, second)
        return left if distance > self._within[first, second] else min(left, 0.0)

    def collide(self, first: int, second: int, pose_1: Matrix, pose_2: Matrix) -> Any:
        """Return coal's result for two shapes at poses (4, 4) in a common frame."""
        request = coal.CollisionRequest()
        request.enable_contact = True
        request.num_max_contacts = CONTACTS_OF_A_PAIR
        request.security_margin = float(self._within[first, second])
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
