# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which pairs of a robot's links touch, or come near each other."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import coal
import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.mesh.coal_shapes import exact_shape, hull_shape
from armsim_ros.model.shape_points import corner_points
from armsim_ros.planning.scene.allowed_collision_matrix import Pair


class LinkPairs:
    """
    Checks pairs of links separately, regardless of the SRDF.

    :param model: the robot; links without shapes are left out.
    :param hulls: whether a mesh counts as its convex hull, as in the physics; else as its
        triangles, as in planning.
    """

    def __init__(self, model: KinematicModel, *, hulls: bool = False) -> None:
        shape_of = hull_shape if hulls else exact_shape
        self._model = model
        self.links = [name for name, link in model.robot.links.items() if link.collisions]
        self._shapes: dict[str, list[tuple[Any, Matrix]]] = {}
        self._spheres: dict[str, tuple[Vector, float]] = {}
        for name in self.links:
            items = model.robot.links[name].collisions
            self._shapes[name] = [(shape_of(item.geometry), item.origin) for item in items]
            self._spheres[name] = _bounding_sphere([
                corner_points(item.geometry, item.origin) for item in items])

    def nearer(self, q: Vector, pairs: Iterable[Pair], distance: float) -> list[Pair]:
        """
        Return the pairs that are nearer than a distance in a state.

        :param q: (n,) joint positions.
        :param distance: [m]; 0 asks for those that touch.
        """
        poses = dict(zip(self.links, self._model.link_poses(q, self.links), strict=True))
        centres = {name: poses[name][:3, :3] @ centre + poses[name][:3, 3]
                   for name, (centre, _) in self._spheres.items()}
        found = []
        for first, second in pairs:
            reach = self._spheres[first][1] + self._spheres[second][1] + distance
            if np.linalg.norm(centres[first] - centres[second]) > reach:
                continue
            if self._is_nearer(first, poses[first], second, poses[second], distance):
                found.append((first, second))
        return found

    def _is_nearer(self, first: str, pose_1: Matrix, second: str, pose_2: Matrix,
                   distance: float) -> bool:
        request = coal.CollisionRequest()
        request.security_margin = distance
        for shape_1, origin_1 in self._shapes[first]:
            place_1 = _transform(pose_1 @ origin_1)
            for shape_2, origin_2 in self._shapes[second]:
                result = coal.CollisionResult()
                coal.collide(shape_1, place_1, shape_2, _transform(pose_2 @ origin_2), request,
                             result)
                if result.isCollision():
                    return True
        return False


def _transform(pose: Matrix) -> Any:
    return coal.Transform3s(pose[:3, :3], pose[:3, 3])


def _bounding_sphere(corners: list[Matrix]) -> tuple[Vector, float]:
    points = np.vstack(corners)
    if not len(points):
        return np.zeros(3), np.inf
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    return centre, float(np.max(np.linalg.norm(points - centre, axis=1)))
