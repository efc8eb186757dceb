# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Runs the actions of a data set again, and compares."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from armsim_ros.data.dataset import INFO, OWN, read_json
from armsim_ros.data.episodes import made, Source, versions
from armsim_ros.data.features import ACTION, frames_of, STATE
from armsim_ros.errors import ConfigError, Problem, ResourceError

#: States that differ by no more are the same.
TOLERANCE = 1e-6


@dataclass(frozen=True)
class Replayed:
    """
    How an episode went again.

    :param number: of the episode.
    :param deviation: largest difference of ``observation.state``.
    :param success: whether it ended as in the data set.
    """

    number: int
    deviation: float
    success: bool

    @property
    def same(self) -> bool:
        """Whether states and success are those of the data set."""
        return self.deviation <= TOLERANCE and self.success


def other_versions(folder: Path) -> list[str]:
    """Return a line for each version that differs from that of the data set."""
    then, now = read_json(folder / OWN)['versions'], versions()
    return [f'the data set was made with {name} {version}, this is {now.get(name)}'
            for name, version in then.items() if now.get(name) != version]


def replay(folder: Path, numbers: Iterable[int] | None = None) -> Iterator[Replayed]:
    """
    Yield how the episodes of a data set go again.

    :param numbers: of the episodes; all by default.
    :raises ResourceError: there is no data set of ``armsim collect``.
    :raises ConfigError: it has no such episode, or no ``observation.state``.
    """
    from pyarrow import compute, parquet

    own, info = read_json(folder / OWN), read_json(folder / INFO)
    if 'env_id' not in own:
        raise ResourceError(f"'{folder}' was not made by armsim collect and cannot be replayed")
    count = int(info['total_episodes'])
    chosen = list(range(count) if numbers is None else numbers)
    for number in chosen:
        if not 0 <= number < count:
            raise ConfigError(Problem(f'--episode {number}', allowed=f'0 to {count - 1}'))
    if STATE not in info['features']:
        raise ConfigError(Problem(f"'{folder}' has no {STATE} to compare"))
    rows = parquet.read_table(folder / 'data', columns=['episode_index', STATE, ACTION],
                              partitioning=None)
    env = made(Source(own['env_id'], own['arguments']))
    try:
        for number in chosen:
            part = rows.filter(compute.equal(rows['episode_index'], number))
            yield _again(env, number, own['episodes'][number], np.array(part[STATE].to_pylist()),
                         np.array(part[ACTION].to_pylist(), dtype=np.float32))
    finally:
        env.close()


def _again(env: Any, number: int, facts: Any, states: Any, actions: Any) -> Replayed:
    observation, info = env.reset(seed=facts['seed'])
    deviation = 0.0
    for state, action in zip(states, actions, strict=True):
        deviation = max(deviation, float(np.abs(frames_of(observation)[STATE] - state).max()))
        observation, _, _, _, info = env.step(action)
    return Replayed(number, deviation, bool(info['is_success']) == facts['success'])
