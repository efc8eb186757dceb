# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Commands of a stream, and the states that it reports."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
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


class ServoStatus(IntEnum):
    """Codes of ``moveit_msgs/msg/ServoStatus``."""

    INVALID = -1
    NO_WARNING = 0
    DECELERATE_FOR_APPROACHING_SINGULARITY = 1
    HALT_FOR_SINGULARITY = 2
    DECELERATE_FOR_LEAVING_SINGULARITY = 3
    DECELERATE_FOR_COLLISION = 4
    HALT_FOR_COLLISION = 5
    JOINT_BOUND = 6


#: What clients of upstream's servo compare messages with.
TEXTS: dict[ServoStatus, str] = {
    ServoStatus.INVALID: 'Invalid',
    ServoStatus.NO_WARNING: 'No warnings',
    ServoStatus.DECELERATE_FOR_APPROACHING_SINGULARITY:
        'Moving closer to a singularity, decelerating',
    ServoStatus.HALT_FOR_SINGULARITY: 'Very close to a singularity, emergency stop',
    ServoStatus.DECELERATE_FOR_LEAVING_SINGULARITY:
        'Moving away from a singularity, decelerating',
    ServoStatus.DECELERATE_FOR_COLLISION: 'Close to a collision, decelerating',
    ServoStatus.HALT_FOR_COLLISION: 'Collision detected, emergency stop',
    ServoStatus.JOINT_BOUND: 'Close to a joint bound (position or velocity), halting',
}

_PRECEDENCE = (
    ServoStatus.INVALID,
    ServoStatus.HALT_FOR_COLLISION,
    ServoStatus.DECELERATE_FOR_COLLISION,
    ServoStatus.JOINT_BOUND,
    ServoStatus.HALT_FOR_SINGULARITY,
    ServoStatus.DECELERATE_FOR_APPROACHING_SINGULARITY,
    ServoStatus.DECELERATE_FOR_LEAVING_SINGULARITY,
    ServoStatus.NO_WARNING,
)


@dataclass(frozen=True, slots=True)
class Finding:
    """
    A finding about a cycle.

    :param detail: names joint, pair, field or number; may be ''.
    """

    code: ServoStatus
    detail: str = ''

    @property
    def message(self) -> str:
        """Upstream's words, with the detail behind them."""
        text = TEXTS[self.code]
        return f'{text}: {self.detail}' if self.detail else text


NOTHING = Finding(ServoStatus.NO_WARNING)


def weightiest(findings: Iterable[Finding]) -> Finding:
    """Return the finding that a status reports, of several."""
    return min(findings, key=lambda finding: _PRECEDENCE.index(finding.code), default=NOTHING)
