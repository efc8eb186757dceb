# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Broad phases: shapes on the joints of a robot, and the quickest test of the pairs of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import coal
import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.planning.collision.boxes import ShapeBoxes
from armsim_ros.planning.collision.contact_query import contact_request, PlaneDistance

CollisionTest = Callable[[Vector], bool]
"""Tests whether a robot state (n,) touches anything."""


#: Visits of pairs by managers that cost as much as a comparison of two boxes on the same joint.
PAIRS_OF_A_JOINT = 10
#: Contacts that are requested of coal for a pair of shapes, to find the deepest.
CONTACTS_OF_A_PAIR = 8
_NOT_CONVEX = (coal.BVHModelBase, coal.OcTree, coal.Plane)


class BroadPhase:
    """
    A set of placed shapes and the pairs of them that are checked.

    Owns Pinocchio's geometry model, its data and the broad phase manager together, because the
    manager and the data hold bare pointers into the model. The manager is coal's naive manager:
    measured against plain pairwise checks the array-based trees and sweep and prune lose
    collisions, and the naive manager is the fastest of those that do not. Pairs of shapes on the
    same joint are left out. Pinocchio's tree of a manager for each joint does not visit them, but
    each of its managers visits all pairs when a joint has moved: see ``PAIRS_OF_A_JOINT``.

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
        self._joints = np.array([joint for joint, _, _ in self._shapes], dtype=np.intp)
        self._pairs, self._margins = pairs, margins
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
        self._boxes: ShapeBoxes | None = None
        #: Requests of pairs; to read them is faster than to find them again.
        self._requests: dict[int, Any] = {}
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
        pairs = [(pair.first, pair.second) for pair in self._geometry.collisionPairs]
        self._pair_table = np.array(pairs, dtype=np.intp).reshape(-1, 2)
        # Pinocchio has GJK begin where it ended the last time. From far away it then loses
        # contacts, such as that of two boxes about a common centre.
        plain, guessing = contact_request(False), contact_request(True)
        for k, pair in enumerate(self._geometry.collisionPairs):
            convex = not any(isinstance(self._shapes[number][2], _NOT_CONVEX)
                             for number in (pair.first, pair.second))
            self._geometry_data.collisionRequests[k] = guessing if convex else plain
            self._geometry_data.distanceRequests[k] = coal.DistanceRequest()
        of_joints = np.bincount(self._joints)
        idle = int((of_joints * (of_joints - 1)).sum()) // 2
        visits = (int(self._model.njoints) - 1) * len(self._geometry.collisionPairs)
        manager = (pin.TreeBroadPhaseManager_NaiveCollisionManager
                   if PAIRS_OF_A_JOINT * idle > visits else
                   pin.BroadPhaseManager_NaiveCollisionManager)
        self._manager = manager(self._model, self._geometry, self._geometry_data)
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
        self._spheres = self._boxes = None
        if self._manager is not None:
            self._geometry.geometryObjects[number].placement = pin.SE3(pose)

    def activate(self, active: Mask) -> None:
        """Check these pairs (g, g) only, of those that can be checked."""
        if self._manager is None:
            self._build()
        if active is not self._active:
            apart = self._joints[:, None] != self._joints
            self._geometry_data.setActiveCollisionPairs(self._geometry, active & apart)
            self._looked_at = active[tuple(self._pair_table.T)]
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

    @property
    def pairs(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """The numbers of the first and of the second shape of all pairs (pairs,)."""
        first, second = self._pair_table.T
        return first, second

    def boxes_near(self, rotations: Matrix, origins: Matrix, margins: Matrix) -> Mask:
        """
        Return which pairs (k, pairs) boxes around the shapes do not show to be apart.

        :param rotations: (k, joints, 3, 3) of the joints in k states.
        :param origins: (k, joints, 3) of the joints [m].
        :param margins: (k, pairs) [m] distance that counts as near.
        """
        if self._boxes is None:
            self._boxes = ShapeBoxes(self._shapes, self._pair_table)
        first, second = self._pair_table.T
        return self._boxes.near(
            rotations, origins, margins,
            self._looked_at & (self._joints[first] != self._joints[second]))

    def touching(
        self, states: Matrix, asked: Mask, margins: Matrix, poll: Callable[[], None], few: int,
    ) -> Mask:
        """
        Return which of some pairs (k, pairs) touch, each by itself.

        :param states: (k, n) robot states.
        :param asked: (k, pairs) the pairs to check.
        :param margins: (k, pairs) [m] distance that counts as contact.
        :param poll: called once for so many states.
        """
        place, touches = pin.updateGeometryPlacements, pin.computeCollision
        geometry, data, requests = self._geometry, self._geometry_data, self._requests
        of_state = self._model, self._data, geometry, data
        # What is set here has to be set again for all pairs.
        self._margins = np.zeros((0, 0))
        found = np.zeros_like(asked)
        rows, pairs = asked.nonzero()
        placed, hits = -1, []
        for number, (k, pair, within) in enumerate(zip(
            rows.tolist(), pairs.tolist(), margins[rows, pairs].tolist(), strict=True
        )):
            if k != placed:
                if placed < 0 or k // few != placed // few:
                    poll()
                place(*of_state, states[k])
                placed = k
            request = requests.get(pair)
            if request is None:
                request = requests[pair] = data.collisionRequests[pair]
            request.security_margin = within
            if touches(geometry, data, pair):
                hits.append(number)
        found[rows[hits], pairs[hits]] = True
        return found

    def deepest(self, pair: int) -> tuple[Vector, Vector, float] | None:
        """
        Return the deepest contact of a pair where the shapes were placed last; None for none.

        :returns: position (3,) [m] and unit normal (3,) from the first shape to the second, in
            the model frame, and their distance [m].
        """
        data = self._geometry_data
        request = data.collisionRequests[pair]
        request.enable_contact, request.num_max_contacts = True, CONTACTS_OF_A_PAIR
        pin.computeCollision(self._geometry, data, pair)
        request.enable_contact, request.num_max_contacts = False, 1
        contacts = data.collisionResults[pair].getContacts()
        if not len(contacts):
            return None
        best = min(contacts, key=lambda contact: contact.penetration_depth)
        return np.array(best.pos), np.array(best.normal), float(best.penetration_depth)

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
        Put a sphere around each of g shapes.

        :returns: the joints that carry shapes, which of those carries each shape (g,), and the
            centres (g, 4, 1) of the spheres on them.
        """
        centres, radii = np.ones((len(self._shapes), 4, 1)), np.zeros(len(self._shapes))
        for number, (_, pose, shape) in enumerate(self._shapes):
            shape.computeLocalAABB()
            centres[number, :3, 0] = pose[:3, :3] @ shape.aabb_center + pose[:3, 3]
            radii[number] = shape.aabb_radius
        self._radii = radii[self._pair_table].sum(axis=1)
        joints, places = np.unique(self._joints, return_inverse=True)
        return [int(joint) for joint in joints], places, centres

    def pose(self, number: int) -> Matrix:
        """Return a shape's pose (4, 4) in the model frame at the last query."""
        pose: Matrix = self._geometry_data.oMg[number].homogeneous
        return pose
