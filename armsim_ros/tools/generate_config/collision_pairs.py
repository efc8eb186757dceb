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

from armsim_ros.arrays import Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.tree import adjacent_pairs
from armsim_ros.planning.scene.allowed_collision_matrix import Pair, sorted_pair
from armsim_ros.tools.generate_config.link_pairs import LinkPairs

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
