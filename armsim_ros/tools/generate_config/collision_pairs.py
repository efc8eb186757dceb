# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Which pairs of links need no collision check, found by sampling joint positions.

The rules are those of MoveIt's setup assistant: neighbours, pairs that touch in the default
state or nearly always, and pairs that were never seen to touch. Here a pair that comes near is
still checked, though no sample touched.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.planning.allowed_collision_matrix import (
    adjacent_pairs,
    AllowedCollisionMatrix,
    Pair,
    sorted_pair,
)
from armsim_ros.planning.collision import CollisionChecker
from armsim_ros.planning.scene import PlanningScene

ADJACENT, ALWAYS, DEFAULT, NEVER = 'Adjacent', 'Always', 'Default', 'Never'

#: States in which all pairs are counted.
COUNTED_STATES = 300
#: A pair that touches in this share of them is always touching.
ALWAYS_SHARE = 0.95
#: Pairs that never come nearer than this are never checked again [m].
NEAR = 0.005

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class SampledPairs:
    """
    Result of the sampling.

    :param disabled: pair -> reason, in the order of the links.
    :param checked: pairs that stay checked -> how many of the states had them touch or near.
    :param states: how many states were looked at.
    """

    disabled: dict[Pair, str]
    checked: dict[Pair, int]
    states: int


def sample_pairs(robot: RobotModel, *, states: int, seed: int = 0,
                 progress: Callable[[int], None] | None = None) -> SampledPairs:
    """
    Find the pairs that need no check.

    :param states: how many random states to look at, at least ``COUNTED_STATES``.
    :param seed: of the random numbers.
    :param progress: is told how many states are done, now and then.
    """
    solid = [name for name, link in robot.links.items() if link.collisions]
    order = {name: place for place, name in enumerate(solid)}
    reasons: dict[Pair, str] = dict.fromkeys(adjacent_pairs(robot), ADJACENT)
    model = KinematicModel(robot)
    generator = np.random.default_rng(seed)
    touching = Counter[Pair]()
    exact = _Probe(model, reasons, 0.0)
    for pair in exact.touching(model.default()):
        reasons[pair] = DEFAULT
    exact = _Probe(model, reasons, 0.0)
    for _ in range(COUNTED_STATES):
        touching.update(exact.touching(random_state(model, generator)))
    for pair, count in touching.items():
        if count >= ALWAYS_SHARE * COUNTED_STATES:
            reasons[pair] = ALWAYS
    checked = {pair: count for pair, count in touching.items() if pair not in reasons}
    near = _Probe(model, {**reasons, **dict.fromkeys(checked, '')}, NEAR)
    for number in range(COUNTED_STATES, max(states, COUNTED_STATES)):
        found = near.touching(random_state(model, generator))
        if found:
            checked.update(dict.fromkeys(found, 1))
            near.allow(found)
        if progress is not None and number % 500 == 0:
            progress(number)
    for place, first in enumerate(solid):
        for second in solid[place + 1:]:
            pair = sorted_pair(first, second)
            if pair not in reasons and pair not in checked:
                reasons[pair] = NEVER
    ordered = sorted(reasons, key=lambda pair: sorted(order[name] for name in pair))
    return SampledPairs({pair: reasons[pair] for pair in ordered}, checked, states)


def random_state(model: KinematicModel, generator: np.random.Generator) -> Vector:
    """Return joint positions, each anywhere between its limits; followers follow."""
    lower = np.maximum(model.lower, -np.pi * 2)
    upper = np.minimum(model.upper, np.pi * 2)
    return model.apply_mimic(generator.uniform(lower, upper))


class _Probe:
    """Tells which pairs touch, of all but those that are named."""

    def __init__(self, model: KinematicModel, without: dict[Pair, str], margin: float) -> None:
        self._scene = PlanningScene(model, auto_disable_adjacent=False)
        self._matrix = AllowedCollisionMatrix().with_pairs(dict.fromkeys(without, True))
        self._scene.set_acm(self._matrix)
        self._checker = CollisionChecker(self._scene, margin=margin)

    def touching(self, q: Vector) -> set[Pair]:
        if not self._checker.maybe_in_collision(q):
            return set()
        return {sorted_pair(one.body1, one.body2) for one in self._checker.contacts(q)}

    def allow(self, pairs: set[Pair]) -> None:
        self._matrix = self._matrix.with_pairs(dict.fromkeys(pairs, True))
        self._scene.set_acm(self._matrix)
