# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How the expert takes a cube, carries it and puts it down."""

from __future__ import annotations

import math
from typing import Any, TYPE_CHECKING

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.tasks.expert import Goal, quarter_turn, yaw_of
from armsim_ros.tasks.workspace import CUBE

if TYPE_CHECKING:
    from armsim_ros.tasks.base import TaskEnv

#: What differs of a cube by default, besides where it is.
CUBE_RANGES: dict[str, Any] = {
    'objects.cube.rpy': ((0.0, 0.0, -math.pi), (0.0, 0.0, math.pi)),
    'objects.cube.mass': (0.05, 0.15), 'objects.cube.friction': (0.6, 1.0),
}
#: Height of the hand over a cube before it goes down [m].
HOVER = 0.05
#: The hand goes down where it is so near to the vertical through its goal [m].
_STRAIGHT = 0.006
#: A cup is on when it is so near to the cube [m].
_SUCK = 0.015
#: So high above its place a cube is let go [m].
_RELEASE = 0.004


def grasp(task: TaskEnv, name: str) -> tuple[Vector, float, float | None]:
    """Return point, level and yaw of the hand that takes an object."""
    hand, item = task.hand, task.item_xyz(name)
    point = hand.point
    aside = math.dist(point[:2], item[:2])
    if hand.model.cup:
        top = item[2] + 0.5 * CUBE
        level = float(hand.holds(name) or (aside < 0.01 and point[2] < top + _SUCK))
        height = top if aside < 2 * _STRAIGHT else max(top + HOVER, point[2] - 0.05)
        return np.append(item[:2], height), level, None
    yaw = yaw_of(task.item_quat(name))
    turned = abs(quarter_turn(yaw - task.hand_yaw)) < 0.06
    if hand.holds(name) or (aside < _STRAIGHT and abs(point[2] - item[2]) < 0.008 and turned):
        return item.copy(), 0.0, yaw
    inside = point[2] < item[2] + 0.5 * CUBE and aside < 0.015
    down = inside or (aside < _STRAIGHT and turned)
    height = item[2] if down else max(item[2] + HOVER + 0.5 * CUBE, point[2] - 0.05)
    return np.append(item[:2], height), 1.0, yaw


def put(task: TaskEnv, name: str, place: Vector, precision: float) -> Goal:
    """
    Return the goal of the hand that puts an object at a place.

    :param place: (3,) where the object's middle shall be [m].
    :param precision: how near to the place it must be to be let go, horizontally [m].
    """
    hand, item = task.hand, task.item_xyz(name)
    aside = math.dist(item[:2], place[:2])
    cup = bool(hand.model.cup)
    free = 0.0 if cup else 1.0
    if not hand.holds(name):
        if aside < 2 * precision and abs(item[2] - place[2]) < 0.01:
            open_wide = cup or hand.level > 0.8
            up = np.append(hand.point[:2], hand.point[2] + (0.1 if open_wide else 0.0))
            return Goal(up, free)
        point, level, yaw = grasp(task, name)
        return Goal(point, level, yaw)
    grip = 1.0 - free
    offset = hand.point - item
    if aside < precision:
        if item[2] < place[2] + _RELEASE:
            return Goal(hand.point.copy(), free)
        slow = 0.05 if item[2] < place[2] + 0.02 else 0.15
        return Goal(np.append(place[:2], place[2]) + offset, grip, speed=slow)
    height = place[2] + HOVER
    if item[2] < height - 0.015:
        return Goal(np.append(hand.point[:2], height + offset[2]), grip)
    return Goal(np.append(place[:2], height) + offset, grip)
