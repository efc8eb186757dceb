# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How a scripted expert moves the hand: a goal for its point becomes an action."""

from __future__ import annotations

from dataclasses import dataclass
import math

import mujoco
import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.env.actions import Actions
from armsim_ros.stack import ArmSim
from armsim_ros.tasks.hand import Hand

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
