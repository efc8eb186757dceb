# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How often a policy solves a task."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, closing, nullcontext
from dataclasses import dataclass, field
import math
from typing import Any

import gymnasium
import numpy as np

from armsim_ros.arrays import Matrix, Vector
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
    :param positions: (steps + 1, n) of all joints at the start and after each step [rad or m].
    :param times: (steps + 1,) of these since the start [s].
    """

    seed: int
    success: bool
    steps: int
    reward: float
    positions: Matrix = field(default_factory=lambda: np.empty((0, 0)), repr=False)
    times: Vector = field(default_factory=lambda: np.empty(0), repr=False)

    def facts(self) -> dict[str, Any]:
        """Return how it ended, without the motion."""
        return {name: getattr(self, name) for name in ('seed', 'success', 'steps', 'reward')}


#: Key of ``info``: time of what is observed since the start, where it is measured [s].
MEASURED_AT = 'measured_at'
Environment = gymnasium.Env[Any, Any]


def evaluate(
    source: Source, episodes: int, seed: int = 0,
    place: Callable[[Environment], AbstractContextManager[Environment]] = nullcontext,
) -> Iterator[Outcome]:
    """
    Yield the outcome of episodes, one per seed.

    :param seed: of the first episode; each next has the next seed.
    :param place: gives the environment that is stepped in place of that of the source.
    :raises ConfigError: no episodes, an unknown id, or a policy that cannot be imported.
    :raises PolicyError: the policy failed.
    """
    if episodes < 1:
        raise ConfigError(Problem(f'--episodes {episodes}', allowed='at least 1'))
    with closing(EpisodeRunner(source)) as runner, place(runner.env) as runner.env:
        joints, period = runner.task.sim.simulation.state, runner.task.period
        for number in range(seed, seed + episodes):
            positions: list[Vector] = []
            times, total, success = [0.0], 0.0, False
            for _, _, reward, info in runner.steps(number):
                positions.append(joints.position.copy())
                times.append(info.get(MEASURED_AT, len(positions) * period))
                total, success = total + reward, bool(info['is_success'])
            yield Outcome(number, success, len(positions), total,
                          np.array([runner.start, *positions]), np.array(times))


def deviations(local: Outcome, other: Outcome) -> Matrix:
    """
    Return how far the joints of another run are from those of the local run at the same times.

    :returns: (steps + 1, n), as long as both last.
    """
    last = local.times[-1] + 1e-9
    rows = other.times <= last
    at = np.column_stack([np.interp(other.times[rows], local.times, path)
                          for path in local.positions.T])
    apart: Matrix = np.abs(other.positions[rows] - at)
    return apart


def success_interval(outcomes: Sequence[Outcome]) -> tuple[float, float]:
    """Return between which rates of success the true rate is with 95 % (Wilson's interval)."""
    count, rate = len(outcomes), sum(each.success for each in outcomes) / len(outcomes)
    centre = rate + _Z**2 / (2 * count)
    spread = _Z * math.sqrt(rate * (1.0 - rate) / count + _Z**2 / (4 * count**2))
    scale = 1.0 + _Z**2 / count
    return max(0.0, (centre - spread) / scale), min(1.0, (centre + spread) / scale)
