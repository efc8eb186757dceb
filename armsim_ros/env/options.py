# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Arguments of environments: choices, the options of ``reset``, and saved states."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from armsim_ros.arrays import Vector
from armsim_ros.env.ranges import Episode, flat
from armsim_ros.errors import ConfigError, nearest, Problem
from armsim_ros.sim.physics.saved_state import SimulationState

#: So many letters may differ for a key to count as misspelled.
_TYPOS = 2


def checked_choices(choices: Mapping[str, tuple[object, tuple[object, ...]]]) -> None:
    """
    Check arguments that are one of a few values.

    :param choices: argument -> value and what is allowed.
    :raises ConfigError: a value that is not allowed.
    """
    problems = [
        Problem(f'{name}={value!r}', allowed=', '.join(map(str, allowed)),
                remedy=nearest(str(value), [str(known) for known in allowed]))
        for name, (value, allowed) in choices.items() if value not in allowed]
    if problems:
        raise ConfigError(problems)


def own_options(options: Mapping[str, Any], known: Iterable[str]) -> dict[str, Any]:
    """
    Return the options that are meant for an environment, as dotted path -> value.

    Callers send keys of their own to every environment, such as ``lerobot_new_rollout``; they
    are ignored. A key that is at most two letters from one of ours is an error.

    :param known: dotted paths.
    :raises ConfigError: a misspelled key.
    """
    heads = dict.fromkeys(path.partition('.')[0] for path in known)
    kept = {}
    for key, value in options.items():
        head = key.partition('.')[0]
        if head in heads:
            kept[key] = value
            continue
        near = [name for name in heads if _distance(head, name) <= _TYPOS]
        if near:
            raise ConfigError(Problem(
                f"reset has no option '{key}'", allowed=', '.join(heads),
                remedy=f"did you mean '{near[0]}'?"))
    return flat(kept)


def _distance(first: str, second: str) -> int:
    """Return by how many letters two words differ (Levenshtein)."""
    row = list(range(len(second) + 1))
    for i, a in enumerate(first, start=1):
        previous, row[0] = row[0], i
        for j, b in enumerate(second, start=1):
            previous, row[j] = row[j], min(row[j] + 1, row[j - 1] + 1, previous + (a != b))
    return row[-1]


@dataclass(frozen=True, eq=False)
class EnvState:
    """
    All that the future of an environment depends on; opaque, may be pickled.

    :param episode: what was drawn.
    :param simulation: physics and drives.
    :param target: (n,) the last command [rad or m].
    :param steps: done in the episode.
    :param waiting: actions that latency holds back.
    :param random: of the environment's random numbers, of the noise and of the pushes.
    :param task: what a task remembers of the episode.
    """

    episode: Episode
    simulation: SimulationState
    target: Vector
    steps: int
    waiting: tuple[Vector, ...]
    random: tuple[Mapping[str, Any], ...]
    task: Mapping[str, Any]
