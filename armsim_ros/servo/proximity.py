# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How near an arm is to a collision, and how much slower that makes it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.collision.contacts import BodyType, PairDistance
from armsim_ros.servo.commands import Finding, ServoStatus

MARGIN = 0.1
"""What is farther from its threshold than this is not checked singly [m]."""
_STEEPNESS = math.log(1000.0)
_GAIN = 1e-7
"""A motion gains distance that gains more than this [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class ClearStates:
    """
    States that are known to be clear because one of them was checked.

    No pair can come nearer than the joints move what they carry.

    :param q: (n,) the state that was checked.
    :param edits: of the scene, up to then.
    :param weights: (k, n) motion of bodies against each other [m/rad or m/m].
    :param margin: (k,) from their distance to the threshold [m].
    """

    q: Vector
    edits: int
    weights: Matrix
    margin: Vector

    def include(self, q: Vector, edits: int) -> bool:
        """Return whether a state (n,) is one of them."""
        return edits == self.edits and bool(
            (self.weights @ np.abs(q - self.q) < self.margin).all())


class Proximity:
    """
    Slows motions down that come near to a collision.

    :param checker: follows the planning scene.
    :param group: the planning group that moves.
    :param self_threshold: the robot slows down this near to itself [m].
    :param scene_threshold: and this near to all else [m].
    """

    def __init__(
        self,
        checker: CollisionChecker,
        group: str,
        self_threshold: float,
        scene_threshold: float,
    ) -> None:
        """Keep the thresholds."""
        self._checker = checker
        self._group = group
        self._self_threshold = self_threshold
        self._scene_threshold = scene_threshold
        self._clear: ClearStates | None = None
        self._slowed = False

    def factor(self, q: Vector, ahead: Vector) -> tuple[float, Finding | None]:
        """
        Return the share of a motion's speed that is left.

        Motion that gains distance keeps all of it, so that there is always a way out.

        :param q: (n,) the robot now.
        :param ahead: (n,) the robot when it has come to rest after the next step.
        :returns: 0 to 1, and findings where it is less than 1.
        """
        edits = self._checker.edits
        if self._clear is not None and self._clear.include(ahead, edits):
            return 1.0, None
        near = self._near(ahead, edits)
        if not near:
            return 1.0, None
        within = 2.0 * self._scene_threshold
        now = _shortest(self._checker.pair_distances(q, within, self._group))
        worst, culprit = 1.0, None
        for pair in near:
            if pair.distance > now.get(pair.names, math.inf) + _GAIN:
                continue
            factor = 0.0
            if pair.distance > 0.0:
                threshold = self._threshold(pair)
                factor = math.exp(-_STEEPNESS * (threshold - pair.distance) / threshold)
            if factor < worst:
                worst, culprit = factor, pair
        if culprit is None:
            return 1.0, None
        if worst == 0.0:
            return 0.0, Finding(ServoStatus.HALT_FOR_COLLISION, culprit.phrase)
        detail = f'{culprit.phrase}, {1000.0 * culprit.distance:.1f} mm apart'
        return worst, Finding(ServoStatus.DECELERATE_FOR_COLLISION, detail)

    def _near(self, q: Vector, edits: int) -> list[PairDistance]:
        """Return the pairs that slow down in a state (n,); and note which states are clear."""
        margin = 0.0 if self._slowed else MARGIN
        pairs = self._checker.pair_distances(
            q, self._scene_threshold + margin, self._group, exact=False)
        near = [pair for pair in pairs if self._slows(pair)]
        relative = self._checker.relative_motion
        moving = [pair for pair in pairs if pair.joints[0] != pair.joints[1]]
        weights = [relative[pair.joints] for pair in moving]
        margins = [pair.distance - self._threshold(pair) for pair in moving]
        self._clear = None if near else ClearStates(
            q, edits, np.array([relative.max(axis=(0, 1)), *weights]),
            np.array([margin, *margins]))
        if near and self._checker.has_hulls:
            pairs = self._checker.pair_distances(q, self._scene_threshold, self._group)
            near = [pair for pair in pairs if self._slows(pair)]
        self._slowed = bool(near)
        return near

    def _slows(self, pair: PairDistance) -> bool:
        """Return whether two bodies are too near; on the same joint, whether they touch."""
        apart = pair.joints[0] != pair.joints[1] and pair.distance >= self._threshold(pair)
        rigid = pair.joints[0] == pair.joints[1] and pair.distance > 0.0
        return not (apart or rigid)

    def _threshold(self, pair: PairDistance) -> float:
        world = BodyType.WORLD_OBJECT in pair.types
        return self._scene_threshold if world else self._self_threshold


def _shortest(pairs: Iterable[PairDistance]) -> dict[tuple[str, str], float]:
    shortest: dict[tuple[str, str], float] = {}
    for pair in pairs:
        shortest[pair.names] = min(pair.distance, shortest.get(pair.names, math.inf))
    return shortest
