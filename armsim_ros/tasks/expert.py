# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How a scripted expert moves the hand: to a point, around a cube, with it, away from it."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Any, TYPE_CHECKING

import mujoco
import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.env.actions import Actions
from armsim_ros.stack import ArmSim
from armsim_ros.tasks.hand import Hand
from armsim_ros.tasks.workspace import CUBE

if TYPE_CHECKING:
    from armsim_ros.tasks.base import TaskEnv

#: The share of the remaining way that is covered in a second [1/s].
_GAIN, _TURN_GAIN = 6.0, 3.0
#: Fastest linear [m/s] and angular [rad/s] velocity.
_FASTEST, _FASTEST_TURN = 0.24, 0.9


@dataclass(frozen=True, eq=False)
class Goal:
    """
    Where the hand shall be.

    :param point: (3,) of the point of the grasp in the world [m].
    :param level: 1 to open the gripper or switch the cup on, 0 to close it or switch it off.
    :param yaw: how an object is turned that the fingers shall be parallel to [rad], if any.
    :param speed: fastest velocity [m/s].
    """

    point: Vector
    level: float
    yaw: float | None = None
    speed: float = _FASTEST


class Steering:
    """
    Turns goals into actions.

    :param actions: of the environment.
    :param period: time of a step [s].
    """

    def __init__(self, actions: Actions, period: float) -> None:
        self._actions = actions
        self._gain = min(_GAIN, 0.5 / period)
        self._upright: Matrix | None = None

    def action(self, hand: Hand, goal: Goal, start: Vector, sim: ArmSim) -> Vector:
        """
        Return the action that moves a hand towards a goal, in units.

        :param start: (n,) where the joints are commanded to be [rad or m].
        """
        linear = self._gain * (goal.point - hand.point)
        linear *= min(1.0, goal.speed / max(1e-9, float(np.linalg.norm(linear))))
        angular = self._turning(hand, goal.yaw)
        tip = sim.simulation.link_pose(self._actions.tip)[:3, 3]
        twist = np.concatenate((linear - np.cross(angular, hand.point - tip), angular))
        others = start[self._actions.others].copy()
        model = hand.model
        if model.joint:
            names = [sim.model.active_joints[i] for i in self._actions.others]
            others[names.index(model.joint)] = (
                model.closed + goal.level * (model.open - model.closed))
        action = self._actions.towards(twist, others, start)
        return np.append(action, goal.level) if model.cup else action

    def _turning(self, hand: Hand, yaw: float | None) -> Vector:
        """Return the angular velocity (3,) that keeps the hand pointing down and turns it."""
        rotation = hand.rotation
        axis = np.argmax(np.abs(hand.model.offset))
        sign = math.copysign(1.0, float(hand.model.offset[axis]))
        pointing = sign * rotation[:, axis]
        turning: Vector = np.cross(pointing, [0.0, 0.0, -1.0])
        if yaw is not None:
            side = rotation[:, (int(axis) + 1) % 3]
            turning[2] += quarter_turn(yaw - math.atan2(side[1], side[0]))
        turning *= _TURN_GAIN
        turning *= min(1.0, _FASTEST_TURN / max(1e-9, float(np.linalg.norm(turning))))
        return turning

    def aside(self, hand: Hand, yaw: float) -> float:
        """Return by how much the hand is not parallel to an object [rad]."""
        axis = int(np.argmax(np.abs(hand.model.offset)))
        side = hand.rotation[:, (axis + 1) % 3]
        return quarter_turn(yaw - math.atan2(side[1], side[0]))


def quarter_turn(angle: float) -> float:
    """Return the angle modulo a quarter turn that is nearest to zero [rad]."""
    return (angle + math.pi / 4) % (math.pi / 2) - math.pi / 4


def yaw_of(quaternion: Vector) -> float:
    """Return how a body is turned about the vertical [rad], of a quaternion wxyz."""
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, quaternion)
    return math.atan2(matrix[3], matrix[0])


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
