# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How near an arm is to a collision, and how much slower that makes it."""

from __future__ import annotations

from collections.abc import Iterable
import math

from armsim_ros.arrays import Vector
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.collision.contacts import BodyType, PairDistance
from armsim_ros.servo.status import Finding, ServoStatus

_STEEPNESS = math.log(1000.0)
_GAIN = 1e-7
"""A motion gains distance that gains more than this [m]."""


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

    def factor(self, q: Vector, ahead: Vector) -> tuple[float, Finding | None]:
        """
        Return the share of a motion's speed that is left.

        Motion that gains distance keeps all of it, so that there is always a way out.

        :param q: (n,) the robot now.
        :param ahead: (n,) the robot when it has come to rest after the next step.
        :returns: 0 to 1, and what to say where it is less than 1.
        """
        if not self._checker.in_collision(
            ahead, self._group, self._scene_threshold, exact=False
        ):
            return 1.0, None
        near = [
            pair
            for pair in self._checker.pair_distances(ahead, self._scene_threshold, self._group)
            if pair.distance < self._threshold(pair)
        ]
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

    def _threshold(self, pair: PairDistance) -> float:
        world = BodyType.WORLD_OBJECT in pair.types
        return self._scene_threshold if world else self._self_threshold


def _shortest(pairs: Iterable[PairDistance]) -> dict[tuple[str, str], float]:
    shortest: dict[tuple[str, str], float] = {}
    for pair in pairs:
        shortest[pair.names] = min(pair.distance, shortest.get(pair.names, math.inf))
    return shortest
