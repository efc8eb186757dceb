# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The command lines of ros_gz_sim's create and gazebo_ros's spawn_entity.py."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

_TEXTS = {'file': 'file', 'string': 'text', 'name': 'name', 'entity': 'name', 'topic': 'topic',
          'param': 'topic', 'world': 'world'}
_NUMBERS = ('x', 'y', 'z', 'R', 'P', 'Y')
_FLAGS = ('allow_renaming', 'unpause', 'stdin', 'database')


@dataclass
class SpawnArguments:
    """What is spawned, and where [m, rad]."""

    name: str = ''
    file: str = ''
    text: str = ''
    topic: str = ''
    world: str = ''
    pose: dict[str, float] = field(default_factory=dict)

    @property
    def by_topic(self) -> bool:
        """Whether the description comes from a topic or parameter."""
        return bool(self.topic) or not (self.file or self.text)

    def placement(self) -> dict[str, list[float]]:
        """Return the pose as the simulation's settings write it."""
        if not any(self.pose.values()):
            return {}
        return {'xyz': [self.pose.get(axis, 0.0) for axis in 'xyz'],
                'rpy': [self.pose.get(axis, 0.0) for axis in 'RPY']}


def read_spawn_arguments(words: Sequence[str]) -> SpawnArguments:
    """Parse the command line; unknown words are skipped, as upstream."""
    found = SpawnArguments()
    rest = iter(words)
    for word in rest:
        name, sign, value = word.lstrip('-').partition('=')
        if not word.startswith('-') or name in _FLAGS:
            continue
        if name in _TEXTS:
            text = value if sign else next(rest, '')
            if text:
                setattr(found, _TEXTS[name], text)
        elif name in _NUMBERS:
            try:
                found.pose[name] = float(value if sign else next(rest, '0'))
            except ValueError:
                found.pose[name] = 0.0
    return found
