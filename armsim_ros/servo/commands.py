# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What may be asked of servo, and what is wrong with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import ArmsimError


class CommandType(IntEnum):
    """Values of ``moveit_msgs/srv/ServoCommandType``."""

    JOINT_JOG = 0
    TWIST = 1
    POSE = 2


class InvalidCommandError(ArmsimError):
    """A command that moves nothing; the text names the field."""


@dataclass(frozen=True, slots=True, eq=False)
class JointJog:
    """
    Velocities of some joints.

    :param names: (k,).
    :param velocities: (k,) times the scale, or [rad/s or m/s]; of a name that is given twice the
        last position counts.
    """

    names: tuple[str, ...]
    velocities: Vector

    type = CommandType.JOINT_JOG

    @property
    def moves(self) -> bool:
        """Whether anything is to move."""
        return bool(self.velocities.any())


@dataclass(frozen=True, slots=True, eq=False)
class Twist:
    """
    Velocity of the tip.

    :param frame: whose axes are meant.
    :param linear: (3,) times the scale, or [m/s].
    :param angular: (3,) times the scale, or [rad/s].
    """

    frame: str
    linear: Vector
    angular: Vector

    type = CommandType.TWIST

    @property
    def moves(self) -> bool:
        """Whether anything is to move."""
        return bool(self.linear.any() or self.angular.any())


@dataclass(frozen=True, slots=True, eq=False)
class PoseTarget:
    """
    Where the tip shall go.

    :param frame: the frame of the pose.
    :param pose: (4, 4).
    """

    frame: str
    pose: Matrix

    type = CommandType.POSE
    moves = True


Command = JointJog | Twist | PoseTarget


def finite_vector(name: str, values: Sequence[float]) -> Vector:
    """
    Return numbers as a vector.

    :param name: of the field, for the message.
    :raises InvalidCommandError: one of them is not finite.
    """
    vector = np.array(values, dtype=np.float64)
    if not np.isfinite(vector).all():
        raise InvalidCommandError(f'{name} holds {vector[~np.isfinite(vector)][0]}')
    return vector
