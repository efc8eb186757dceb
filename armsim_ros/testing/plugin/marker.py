# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The marker ``armsim``: which arm a test wants."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import pytest

from armsim_ros.errors import nearest

MODES = ('inprocess', 'process')
DESCRIPTION = (
    "armsim(robot='sunday', world=None, mode='inprocess', seed=0, time_limit=60, faults={}, "
    "overrides={}): the arm that the fixture 'arm' gives to a test, its class or its module"
)


@dataclass(frozen=True)
class ArmRequest:
    """
    What a test wants.

    :param robot: a name or a folder, as ``bringup robot:=`` takes it.
    :param world: a world's name or file in place of the robot's own.
    :param mode: ``inprocess`` steps the stack in the test's process, ``process`` starts the real
        programs on a ROS domain of their own.
    :param seed: of the planner's random numbers.
    :param time_limit: what a test may take, both of simulated and of wall time [s].
    :param faults: joint -> what is wrong with it, such as ``{'joint_1': {'blocked': True}}``.
    :param overrides: dotted path -> value over the robot's files, such as
        ``{'simulation.gravity': [0, 0, 0]}``.
    """

    robot: str = 'sunday'
    world: str | None = None
    mode: str = 'inprocess'
    seed: int = 0
    time_limit: float = 60.0
    faults: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    overrides: Mapping[str, Any] = field(default_factory=dict)

    @property
    def build_key(self) -> tuple[str, str | None, str]:
        """What two tests must have in common to share a build."""
        return self.robot, self.world, repr(sorted(self.overrides.items()))


WORDS = tuple(field.name for field in fields(ArmRequest))


def requested(node: Any, *, mode: str, seed: int) -> ArmRequest:
    """
    Return the arguments of a test's markers; the innermost marker wins, argument by argument.

    :param node: the test, or the module for fixtures of a module.
    :param mode: where no marker sets it.
    :param seed: where no marker sets it.
    :raises pytest.UsageError: a word that there is not, or a value that cannot be.
    """
    words: dict[str, Any] = {'mode': mode, 'seed': seed}
    for marker in reversed(list(node.iter_markers('armsim'))):
        if marker.args:
            raise pytest.UsageError(
                f'{node.nodeid}: armsim() takes keyword arguments only, such as robot=...; '
                f'got {marker.args}')
        words.update(_checked(node.nodeid, marker.kwargs, words.get('overrides', {})))
    return ArmRequest(**words)


def _checked(where: str, given: Mapping[str, Any], before: Mapping[str, Any]) -> dict[str, Any]:
    words: dict[str, Any] = {}
    overrides = {**before, **given.get('overrides', {})}
    for word, value in given.items():
        if '.' in word:
            overrides[word] = value
        elif word in WORDS:
            words[word] = value
        else:
            hint = nearest(word, WORDS)
            raise pytest.UsageError(
                f"{where}: armsim() has no argument '{word}'; allowed: {', '.join(WORDS)}, or a "
                f"dotted path of the robot's settings{'; ' if hint else ''}{hint}")
    if words.get('mode', MODES[0]) not in MODES:
        raise pytest.UsageError(
            f"{where}: armsim(mode={words['mode']!r}); allowed: {', '.join(MODES)}")
    limit = words.get('time_limit', 1.0)
    if not isinstance(limit, (int, float)) or not limit > 0:
        raise pytest.UsageError(f'{where}: armsim(time_limit={limit!r}) must be above 0 [s]')
    if not isinstance(words.get('seed', 0), int):
        raise pytest.UsageError(f"{where}: armsim(seed={words['seed']!r}) must be a whole number")
    return {**words, 'overrides': overrides} if overrides else words
