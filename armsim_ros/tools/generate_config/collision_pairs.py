# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Pairs of links that never, always or only by default touch, from random states."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import coal
import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.coal_shapes import exact_shape, hull_shape
from armsim_ros.model.geometry import corner_points
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.tree import adjacent_pairs
from armsim_ros.planning.scene.allowed_collision_matrix import Pair, sorted_pair


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


ADJACENT, ALWAYS, DEFAULT, NEVER = 'Adjacent', 'Always', 'Default', 'Never'

#: States in which all pairs are counted.
COUNTED_STATES = 300
#: A pair that touches in this share of them is always touching.
ALWAYS_SHARE = 0.95
#: Pairs that never come nearer than this are never checked again [m].
NEAR = 0.005


@dataclass(frozen=True)
class SampledPairs:
    """
    Result of the sampling.

    :param disabled: pair -> reason, in the order of the links.
    :param checked: pairs that stay checked -> how many of the states had them touch or near.
    :param states: how many states were checked.
    """

    disabled: dict[Pair, str]
    checked: dict[Pair, int]
    states: int


def sample_pairs(robot: RobotModel, *, states: int, seed: int = 0,
                 progress: Callable[[int], None] | None = None) -> SampledPairs:
    """
    Find the pairs that need no check.

    :param states: how many random states to check, at least ``COUNTED_STATES``.
    :param seed: of the random numbers.
    :param progress: is called with how many states are done, now and then.
    """
    model = KinematicModel(robot)
    links = LinkPairs(model)
    order = {name: place for place, name in enumerate(links.links)}
    reasons: dict[Pair, str] = dict.fromkeys(adjacent_pairs(robot), ADJACENT)
    open_pairs = [pair for pair in _all_pairs(links.links) if pair not in reasons]
    generator = np.random.default_rng(seed)
    reasons |= dict.fromkeys(links.nearer(model.default(), open_pairs, 0.0), DEFAULT)
    open_pairs = [pair for pair in open_pairs if pair not in reasons]
    touching = Counter[Pair]()
    for _ in range(COUNTED_STATES):
        touching.update(links.nearer(random_state(model, generator), open_pairs, 0.0))
    reasons |= {pair: ALWAYS for pair, count in touching.items()
                if count >= ALWAYS_SHARE * COUNTED_STATES}
    checked = {pair: count for pair, count in touching.items() if pair not in reasons}
    open_pairs = [pair for pair in open_pairs if pair not in touching]
    for number in range(COUNTED_STATES, max(states, COUNTED_STATES)):
        near = links.nearer(random_state(model, generator), open_pairs, NEAR)
        if near:
            checked |= dict.fromkeys(near, 1)
            open_pairs = [pair for pair in open_pairs if pair not in checked]
        if progress is not None and number % 500 == 0:
            progress(number)
    reasons |= dict.fromkeys(open_pairs, NEVER)
    ordered = sorted(reasons, key=lambda pair: sorted(order[name] for name in pair))
    return SampledPairs({pair: reasons[pair] for pair in ordered}, checked, states)


def _all_pairs(links: list[str]) -> list[Pair]:
    return [sorted_pair(first, second) for place, first in enumerate(links)
            for second in links[place + 1:]]


def random_state(model: KinematicModel, generator: np.random.Generator) -> Vector:
    """Return joint positions, each anywhere between its limits; followers follow."""
    lower = np.maximum(model.lower, -np.pi * 2)
    upper = np.minimum(model.upper, np.pi * 2)
    return model.apply_mimic(generator.uniform(lower, upper))
