# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Pinocchio's collision detection with the one manager that is both right and fast."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

Matrix = NDArray[np.float64]
Mask = NDArray[np.bool_]
Vector = NDArray[np.float64]


class BroadPhase:
    """
    A set of placed shapes and the pairs of them that are checked.

    Owns Pinocchio's geometry model, its data and the broad phase manager together, because the
    manager and the data hold bare pointers into the model. The manager is coal's naive one
    behind Pinocchio's tree: measured against plain pairwise checks the array-based trees and
    sweep and prune lose collisions, and this one is the fastest of those that do not. Like all of
    Pinocchio's managers it leaves out pairs of shapes on one joint.

    :param model: Pinocchio's kinematic model; somebody else keeps it alive as well.
    """

    def __init__(self, model: Any) -> None:
        """Begin without shapes."""
        self._model = model
        self._data = model.createData()
        self._geometry = pin.GeometryModel()
        self._geometry_data: Any = None
        self._manager: Any = None
        self._shapes: list[tuple[int, Matrix, Any]] = []
        self._built = 0
        self._pairs: Mask = np.zeros((0, 0), dtype=bool)
        self._active: Mask | None = None
        self._margins: Matrix | None = None

    @property
    def pairs(self) -> Mask:
        """The pairs (g, g) that can be checked, upper triangle."""
        return self._pairs

    def rebuild(
        self,
        shapes: Sequence[tuple[int, Matrix, Any]],
        pairs: Mask,
        margins: Matrix,
        *,
        keep: int,
    ) -> None:
        """
        Set the shapes and pairs; :meth:`activate` has to follow before any question.

        :param shapes: (joint, pose (4, 4) on it, coal shape) each.
        :param pairs: (g, g) upper triangle.
        :param margins: (g, g) [m] distance that counts as contact.
        :param keep: how many of the first shapes are already there.
        """
        self._manager = self._geometry_data = None
        self._built = min(self._built, keep)
        self._shapes = list(shapes)
        self._pairs = pairs
        self._active, self._margins = None, margins

    def _build(self) -> None:
        """Take over shapes and pairs; done at the first question, so as not to do it in vain."""
        # Adding a shape moves the others in memory: nobody may point at them then.
        if self._built == 0:
            self._geometry = pin.GeometryModel()
        for number, (joint, pose, shape) in enumerate(self._shapes[self._built:], self._built):
            self._geometry.addGeometryObject(
                pin.GeometryObject(str(number), joint, pin.SE3(pose), shape)
            )
        self._built = len(self._shapes)
        self._geometry.setCollisionPairs(self._pairs)
        self._geometry_data = pin.GeometryData(self._geometry)
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
        if number < self._built:
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

    def pose(self, number: int) -> Matrix:
        """Return a shape's pose (4, 4) in the model frame at the last query."""
        pose: Matrix = self._geometry_data.oMg[number].homogeneous
        return pose
