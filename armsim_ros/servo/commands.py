# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Commands of a stream, which of them holds now, and the states that the stream reports."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from enum import IntEnum
import math

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
    ServoStatus.INVALID, ServoStatus.HALT_FOR_COLLISION, ServoStatus.JOINT_BOUND,
    ServoStatus.DECELERATE_FOR_COLLISION, ServoStatus.HALT_FOR_SINGULARITY,
    ServoStatus.DECELERATE_FOR_APPROACHING_SINGULARITY,
    ServoStatus.DECELERATE_FOR_LEAVING_SINGULARITY, ServoStatus.NO_WARNING)


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


FARTHEST_AHEAD_NS = 500_000_000
"""A stamp farther in the future comes from another clock [ns]."""
COMPLAINT_NS = 250_000_000
"""How long an error is reported [ns]."""

_SERVICE = '~/switch_command_type'
_NUMBERS = ', '.join(f'{kind.value} for {kind.name}' for kind in CommandType)


class CommandInbox:
    """
    Keeps the newest command that may be followed, and why others may not.

    :param timeout_ns: a command this old moves nothing any more [ns].
    """

    def __init__(self, timeout_ns: int) -> None:
        """Start without command and without a chosen type."""
        self.timeout_ns = timeout_ns
        self.type: CommandType | None = None
        #: Whether the first command chooses the type.
        self.topic_chooses = False
        #: Whether the last command has become too old; not where it was refused or forgotten.
        self.ceased = False
        self._command: Command | None = None
        self._expires_ns = 0
        self._complaint = ''
        self._complaint_ns = 0

    def choose(self, kind: CommandType) -> None:
        """Follow commands of this type from now on."""
        if kind is not self.type:
            self._command = None
        self.type = kind
        self._complaint = ''

    def forget(self) -> None:
        """Follow only commands that come from now on."""
        self._command = None
        self._complaint = ''
        self.ceased = False

    def receive(
        self, kind: CommandType, read: Callable[[], Command], stamp_ns: int, now_ns: int
    ) -> None:
        """
        Take a command.

        :param read: makes it; InvalidCommandError names the wrong field.
        :param stamp_ns: 0 is now.
        """
        refusal = self._refusal(kind, stamp_ns, now_ns)
        if refusal:
            if self.command(now_ns) is None:  # else a stream is followed, and the status is its
                self.complain(refusal, now_ns)
            return
        try:
            command = read()
        except InvalidCommandError as error:
            self._command = None
            self.complain(str(error), now_ns)
            return
        self._command = command
        self._complaint = ''
        self.ceased = False
        # A stamp ahead of us must not let the command live longer.
        self._expires_ns = min(stamp_ns or now_ns, now_ns) + self.timeout_ns

    def complain(self, text: str, now_ns: int) -> None:
        """Report a finding for a while."""
        self.ceased = False
        self._complaint, self._complaint_ns = text, now_ns

    def reject(self, text: str, now_ns: int) -> None:
        """Drop the command that holds, and report why."""
        self._command = None
        self.complain(text, now_ns)

    def command(self, now_ns: int) -> Command | None:
        """Return the command to follow, None where there is none or it is too old."""
        if self._command is not None and now_ns >= self._expires_ns:
            self._command = None
            self.ceased = True
        return self._command

    def left(self, now_ns: int) -> float:
        """Return how long the command still holds [s]; infinite where there is none."""
        return math.inf if self._command is None else (self._expires_ns - now_ns) * 1e-9

    @property
    def silent(self) -> bool:
        """Whether there is no command, and nothing to report."""
        return self._command is None and not self._complaint

    def complaint(self, now_ns: int) -> str:
        """Return what was wrong with a command of late, '' where nothing was."""
        if self._complaint and not 0 <= now_ns - self._complaint_ns < COMPLAINT_NS:
            self._complaint = ''
        return self._complaint

    def _refusal(self, kind: CommandType, stamp_ns: int, now_ns: int) -> str:
        if self.type is None and self.topic_chooses:
            self.type = kind
        if self.type is None:
            return f'no command type is chosen; call {_SERVICE} with {_NUMBERS}'
        if kind is not self.type:
            return (
                f'a {kind.name} command came and {self.type.name} is chosen; call {_SERVICE} '
                f'with {kind.value}')
        if stamp_ns:
            behind = now_ns - stamp_ns
            if behind > self.timeout_ns or -behind > FARTHEST_AHEAD_NS:
                side = 'behind' if behind > 0 else 'ahead of'
                return (
                    f'header.stamp is {abs(behind) * 1e-9:.3f} s {side} the clock of servo_node; '
                    'set use_sim_time alike on both sides, or send stamp 0')
        return ''
