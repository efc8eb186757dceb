# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The task of pushing a cube over the table."""

from __future__ import annotations

from collections.abc import Mapping
import math
from typing import Any

import numpy as np

from armsim_ros.env.ranges import Episode
from armsim_ros.tasks.base import TaskEnv
from armsim_ros.tasks.expert import Goal
from armsim_ros.tasks.workspace import CUBE

#: How near to the mark the cube has to be, horizontally [m].
PUSHED = 0.03
#: A cube that was lifted higher was carried, not pushed [m].
HIGHEST = 0.02
#: Nearest mark of an episode [m].
_NEAREST = 0.06
#: Distance behind the cube from which the hand pushes [m].
_BEHIND = 0.062
_LOW = 0.03
#: The cube starts in this share of the workspace: the hand has to get behind it.
_MIDDLE = 0.6


class PushCube(TaskEnv):
    """The cube rests at the mark, is not held, and never was lifted."""

    task = 'PushCube'
    task_description = 'Push the red cube onto the green mark.'
    mark = 'disc'
    default_steps = 200
    _highest: float
    _start: float

    def default_ranges(self) -> dict[str, Any]:
        """Return the cube's and the target's."""
        return {'objects.cube.xyz': self.place.on_table(share=_MIDDLE),
                'target.xyz': self.place.on_table(0.0),
                'objects.cube.friction': (0.4, 0.8), 'objects.cube.mass': (0.05, 0.15)}

    def is_possible(self) -> bool:
        """Return whether the mark is far enough from the cube."""
        return self._way() >= _NEAREST

    def solved(self) -> bool:
        """Return whether the cube rests at the mark and was pushed there."""
        self._highest = max(self._highest, float(self.item_xyz('cube')[2]) - self._start)
        return self._way() <= PUSHED and self._highest <= HIGHEST and self.rests('cube')

    def remaining(self) -> float:
        """Return the way of the cube to the mark, and half of that of the hand to the cube."""
        return self._way() + 0.5 * math.dist(self.hand.point, self.item_xyz('cube'))

    def goal(self) -> Goal:
        """Return behind the cube, down, and along to the mark."""
        point, item, target = self.hand.point, self.item_xyz('cube'), self.target
        way, left = target[:2] - item[:2], self._way()
        along = way / max(left, 1e-9)
        behind = point[:2] - item[:2]
        back = -float(behind @ along)
        aside = behind + back * along
        high = item[2] + CUBE + 0.03
        if left < 0.4 * PUSHED:
            return Goal(np.append(point[:2], high), 0.0)
        is_low = point[2] < item[2] + _LOW
        if is_low and back > 0.5 * CUBE and float(np.linalg.norm(aside)) < 0.012:
            ahead = point[:2] + along * 0.04 - 1.5 * aside
            return Goal(np.append(ahead, item[2]), 0.0, speed=min(0.12, max(0.04, 1.5 * left)))
        start = item[:2] - along * _BEHIND
        if math.dist(point[:2], start) < 0.01:
            return Goal(np.append(start, item[2]), 0.0)
        if is_low or point[2] < high - 0.02:
            return Goal(np.append(point[:2], high + 0.01), 0.0)
        return Goal(np.append(start, high), 0.0)

    def task_state(self) -> Mapping[str, Any]:
        """Return what is remembered: also how high the cube was."""
        return {**super().task_state(), '_highest': self._highest, '_start': self._start}

    def _way(self) -> float:
        return math.dist(self.item_xyz('cube')[:2], self.target[:2])

    def _begin(self, episode: Episode) -> None:
        super()._begin(episode)
        self._start = float(self.item_xyz('cube')[2])
        self._highest = 0.0
