# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tasks that end with a cube at rest on something: a mark on the table, another cube."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np

from armsim_ros.model.transforms import matrix_from_quat_wxyz
from armsim_ros.tasks.base import REST, TaskEnv
from armsim_ros.tasks.expert import Goal
from armsim_ros.tasks.grasping import CUBE_RANGES, put
from armsim_ros.tasks.workspace import CUBE

#: How near to the mark the cube has to be, horizontally [m].
PLACED = 0.02
#: How far inside the edge of the lower cube the middle of the upper cube has to be [m].
INSIDE = 0.01
#: From the bottom of a cube to its middle [m].
_HALF = np.array([0.0, 0.0, 0.5 * CUBE])
#: How exactly one is at the height of what it rests on [m].
_ON = 0.008
#: Largest tilt of the lower cube, as the cosine.
_UPRIGHT = math.cos(0.1)


class PlaceCube(TaskEnv):
    """The cube rests on the mark and is not held."""

    task = 'PlaceCube'
    task_description = 'Put the red cube on the green mark.'
    mark = 'disc'

    def default_ranges(self) -> dict[str, Any]:
        """Return the cube's and the target's."""
        return {'objects.cube.xyz': self.place.on_table(), 'target.xyz': self.place.on_table(0.0),
                **CUBE_RANGES}

    def solved(self) -> bool:
        """Return whether the cube rests on the mark."""
        item, target = self.item_xyz('cube'), self.target
        return (math.dist(item[:2], target[:2]) <= PLACED
                and abs(item[2] - target[2] - 0.5 * CUBE) < _ON and self.rests('cube'))

    def remaining(self) -> float:
        """Return the way of the cube to the mark, and half of that of the hand to the cube."""
        goal, item = self.target + _HALF, self.item_xyz('cube')
        return math.dist(item, goal) + 0.5 * math.dist(self.hand.point, item)

    def goal(self) -> Goal:
        """Return the next goal of taking the cube to the mark."""
        return put(self, 'cube', self.target + _HALF, 0.006)


class StackCubes(TaskEnv):
    """The red cube rests on the green cube, which is flat on the table, and is not held."""

    task = 'StackCubes'
    task_description = 'Put the red cube on the green cube.'
    cubes: ClassVar = (('red', (0.8, 0.15, 0.1)), ('green', (0.1, 0.6, 0.2)))

    def default_ranges(self) -> dict[str, Any]:
        """Return those of both cubes."""
        ranges = {}
        for name, _ in self.cubes:
            ranges[f'objects.{name}.xyz'] = self.place.on_table()
            ranges |= {path.replace('cube', name): span for path, span in CUBE_RANGES.items()}
        return ranges

    def solved(self) -> bool:
        """Return whether red rests on green."""
        red, green = self.item_xyz('red'), self.item_xyz('green')
        turn = matrix_from_quat_wxyz(self.item_quat('green'))
        # On whichever face green is: the two shortest ways along its axes are horizontal.
        aside = np.sort(np.abs(turn.T @ (red - green)))[1]
        return bool(
            aside <= 0.5 * CUBE - INSIDE
            and abs(red[2] - green[2] - CUBE) < _ON and self.rests('red')
            and abs(green[2] - self.place.surface - 0.5 * CUBE) < _ON
            and self.item_speed('green') < REST and np.abs(turn[2]).max() > _UPRIGHT)

    def remaining(self) -> float:
        """Return the way of red to its place, and half of that of the hand to red."""
        goal, red = self.item_xyz('green') + 2.0 * _HALF, self.item_xyz('red')
        return math.dist(red, goal) + 0.5 * math.dist(self.hand.point, red)

    def goal(self) -> Goal:
        """Return the next goal of taking red onto green."""
        return put(self, 'red', self.item_xyz('green') + 2.0 * _HALF, 0.004)
