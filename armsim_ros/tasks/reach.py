# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tasks that end in the air: reach a point, pick up a cube."""

from __future__ import annotations

from collections.abc import Mapping
import math
from typing import Any, ClassVar

import numpy as np

from armsim_ros.env.ranges import Episode
from armsim_ros.tasks.base import REST, TaskEnv
from armsim_ros.tasks.expert import Goal
from armsim_ros.tasks.grasping import CUBE_RANGES, grasp

#: How near to its target the hand has to be [m].
REACHED = 0.02
#: How far a cube has to be lifted [m].
LIFTED = 0.10


class Reach(TaskEnv):
    """The hand's point comes to rest within 0.02 m of the target."""

    task = 'Reach'
    task_description = 'Move the hand to the green ball.'
    default_steps = 100
    cubes: ClassVar = ()
    mark = 'ball'

    def default_ranges(self) -> dict[str, Any]:
        """Return the target's."""
        return {'target.xyz': self.place.above(0.04, 0.20)}

    def solved(self) -> bool:
        """Return whether the hand is there and slow."""
        return self.remaining() <= REACHED and self.hand.speed < REST

    def remaining(self) -> float:
        """Return the distance to the target."""
        return math.dist(self.hand.point, self.target)

    def goal(self) -> Goal:
        """Return the target."""
        return Goal(self.target.copy(), 0.0)


class PickCube(TaskEnv):
    """The cube is held 0.10 m above where it was."""

    task = 'PickCube'
    task_description = 'Pick up the red cube.'

    def default_ranges(self) -> dict[str, Any]:
        """Return the cube's."""
        return {'objects.cube.xyz': self.place.on_table(), **CUBE_RANGES}

    def solved(self) -> bool:
        """Return whether the cube is held and up."""
        return self._height() >= LIFTED and self.hand.holds('cube')

    def remaining(self) -> float:
        """Return the way of the hand to the cube, and of the cube up."""
        reach = math.dist(self.hand.point, self.item_xyz('cube'))
        return max(0.0, LIFTED - self._height()) + (0.0 if self.hand.holds('cube') else reach)

    def goal(self) -> Goal:
        """Return over the cube, down to it, up with it."""
        point, level, yaw = grasp(self, 'cube')
        if self.hand.holds('cube'):
            point = np.append(self.hand.point[:2], self.hand.point[2] + 0.1)
        return Goal(point, level, yaw)

    def task_state(self) -> Mapping[str, Any]:
        """Return what is remembered: also where the cube was."""
        return {**super().task_state(), '_start': self._start}

    def _height(self) -> float:
        return float(self.item_xyz('cube')[2]) - self._start

    def _begin(self, episode: Episode) -> None:
        super()._begin(episode)
        self._start = float(self.item_xyz('cube')[2])
