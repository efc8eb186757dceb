# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Pinocchio's collision detection with the one manager that is both right and fast."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from armsim_ros.arrays import Mask, Matrix, Vector

#: Ask only whether two shapes touch.
_NOTHING_ELSE = coal.CollisionRequestFlag.NO_REQUEST


class BroadPhase:
    """
    A set of placed shapes and the pairs of them that are checked.

    Owns Pinocchio's geometry model, its data and the broad phase manager together, because the
    manager and the data hold bare pointers into the model. The manager is coal's naive one
    behind Pinocchio's tree: measured against plain pairwise checks the array-based trees and
    sweep and prune lose collisions, and this one is the fastest of those that do not. Like all of
    Pinocchio's managers it leaves out pairs of shapes on one joint.

    :param model: Pinocchio's kinematic model; somebody else keeps it alive as well.
    :param shapes: (joint, pose (4, 4) on it, coal shape) each.
    :param pairs: (g, g) upper triangle, the pairs that can be checked.
    :param margins: (g, g) [m] distance that counts as contact.
    """

    def __init__(
        self, model: Any, shapes: Sequence[tuple[int, Matrix, Any]], pairs: Mask, margins: Matrix
    ) -> None:
        self._model = model
        self._shapes = list(shapes)
        self._pairs = pairs
        self._margins = margins
        self._active: Mask | None = None
        self._geometry: Any = None
        self._geometry_data: Any = None
        self._manager: Any = None
        self._data: Any = None
        self._spheres: tuple[list[Vector], Vector] | None = None
        self._pair_table = np.zeros((0, 2), dtype=np.intp)

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
        # contacts, such as that of two boxes about one centre.
        for requests, plain in (
            (self._geometry_data.collisionRequests, coal.CollisionRequest(_NOTHING_ELSE, 1)),
            (self._geometry_data.distanceRequests, coal.DistanceRequest()),
        ):
            for k in range(len(requests)):
                requests[k] = plain
        self._manager = pin.TreeBroadPhaseManager_NaiveCollisionManager(
            self._model, self._geometry, self._geometry_data
        )
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
        if self._manager is not None:
            self._geometry.geometryObjects[number].placement = pin.SE3(pose)

    def activate(self, active: Mask) -> None:
        """Check these pairs (g, g) only, of those that can be checked."""
        if self._manager is None:
            self._build()
        if active is not self._active:
            self._geometry_data.setActiveCollisionPairs(self._geometry, active)
            self._active = active

    def hit(self, q: Vector) -> bool:
        """Return whether any active pair touches; ends at the first."""
        found: bool = pin.computeCollisions(self._model, self._data, self._manager, q, True)
        return found

    def judge(self) -> Callable[[Vector], bool]:
        """Return :meth:`hit` in its quickest form, of use until the shapes change."""
        collide = pin.computeCollisions
        model, data, manager = self._model, self._data, self._manager
        return lambda q: collide(model, data, manager, q, True)

    def touching(self, q: Vector) -> list[tuple[int, int]]:
        """Return all active pairs that touch, by plain pairwise checks."""
        data = self._geometry_data
        pin.computeCollisions(self._model, self._data, self._geometry, data, q, False)
        active = data.activeCollisionPairs
        results = data.collisionResults
        return [
            (pair.first, pair.second)
            for k, pair in enumerate(self._geometry.collisionPairs)
            if active[k] and results[k].isCollision()
        ]

    def distances(self, q: Vector) -> list[tuple[int, int, float]]:
        """Return (first, second, distance [m]) of all active pairs; negative where they touch."""
        data = self._geometry_data
        pin.computeDistances(self._model, self._data, self._geometry, data, q)
        active = data.activeCollisionPairs
        results = data.distanceResults
        return [
            (pair.first, pair.second, float(results[k].min_distance))
            for k, pair in enumerate(self._geometry.collisionPairs)
            if active[k]
        ]

    def near(self, q: Vector, within: float) -> list[tuple[int, int, float]]:
        """
        Return (first, second, distance [m]) of the active pairs nearer than ``within`` [m].

        What spheres around the shapes show to be farther apart is not measured.
        """
        geometry, data = self._geometry, self._geometry_data
        pin.updateGeometryPlacements(self._model, self._data, geometry, data, q)
        if self._spheres is None:
            shapes = [item.geometry for item in geometry.geometryObjects]
            for shape in shapes:
                shape.computeLocalAABB()
            self._spheres = (
                [np.array(shape.aabb_center) for shape in shapes],
                np.array([float(shape.aabb_radius) for shape in shapes]),
            )
            pairs = [(pair.first, pair.second) for pair in geometry.collisionPairs]
            self._pair_table = np.array(pairs, dtype=np.intp).reshape(-1, 2)
        local, radii = self._spheres
        centres = np.array([
            data.oMg[number].act(centre) for number, centre in enumerate(local)
        ]).reshape(-1, 3)  # fmt: skip
        first, second = self._pair_table.T
        apart = np.linalg.norm(centres[first] - centres[second], axis=1)
        active = np.array(data.activeCollisionPairs, dtype=bool)
        found = []
        for k in np.flatnonzero(active & (apart < radii[first] + radii[second] + within)):
            distance = float(pin.computeDistance(geometry, data, int(k)).min_distance)
            if distance < within:
                found.append((int(first[k]), int(second[k]), distance))
        return found

    def pose(self, number: int) -> Matrix:
        """Return a shape's pose (4, 4) in the model frame at the last query."""
        pose: Matrix = self._geometry_data.oMg[number].homogeneous
        return pose
