# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The tasks: reach a point; lift a cube, put it on a mark or on another cube, push it."""

from __future__ import annotations

from collections.abc import Mapping
import math
from typing import Any, ClassVar

import numpy as np

from armsim_ros.env.ranges import Episode
from armsim_ros.model.transforms import matrix_from_quat_wxyz
from armsim_ros.tasks.base import REST, TaskEnv
from armsim_ros.tasks.expert import CUBE_RANGES, Goal, grasp, put
from armsim_ros.tasks.workspace import CUBE

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
