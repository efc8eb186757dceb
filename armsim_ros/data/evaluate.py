# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How often a policy solves a task."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
import math

from armsim_ros.data.episodes import EpisodeRunner, Source
from armsim_ros.errors import ConfigError, Problem

#: Of the normal distribution, for an interval of 95 %.
_Z = 1.959964


@dataclass(frozen=True)
class Outcome:
    """
    How an episode ended.

    :param seed: of the episode.
    :param success: whether the task was solved.
    :param steps: until the end.
    :param reward: the sum of its rewards.
    """

    seed: int
    success: bool
    steps: int
    reward: float


def evaluate(source: Source, episodes: int, seed: int = 0) -> Iterator[Outcome]:
    """
    Yield the outcome of episodes, one per seed.

    :param seed: of the first episode; each next has the next seed.
    :raises ConfigError: no episodes, an unknown id, or a policy that cannot be imported.
    :raises PolicyError: the policy failed.
    """
    if episodes < 1:
        raise ConfigError(Problem(f'--episodes {episodes}', allowed='at least 1'))
    runner = EpisodeRunner(source)
    try:
        for number in range(seed, seed + episodes):
            steps, total, success = 0, 0.0, False
            for _, _, reward, info in runner.steps(number):
                steps, total, success = steps + 1, total + reward, bool(info['is_success'])
            yield Outcome(number, success, steps, total)
    finally:
        runner.close()


def success_interval(outcomes: Sequence[Outcome]) -> tuple[float, float]:
    """Return between which rates of success the true rate is with 95 % (Wilson's interval)."""
    count, rate = len(outcomes), sum(each.success for each in outcomes) / len(outcomes)
    centre = rate + _Z**2 / (2 * count)
    spread = _Z * math.sqrt(rate * (1.0 - rate) / count + _Z**2 / (4 * count**2))
    scale = 1.0 + _Z**2 / count
    return max(0.0, (centre - spread) / scale), min(1.0, (centre + spread) / scale)
