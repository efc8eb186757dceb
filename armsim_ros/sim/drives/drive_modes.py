# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The interfaces that a joint offers, and what its drive follows: by claims and mock hardware."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Mask, Vector
from armsim_ros.control.hardware_interface import (
    ACCELERATION,
    COMMAND_INTERFACES,
    EFFORT,
    JointArrays,
    POSITION,
    VELOCITY,
)
from armsim_ros.errors import SimulationError
from armsim_ros.model.robot_model import HardwareJoint, RobotModel

_FOLLOWING = (POSITION, VELOCITY, ACCELERATION)
_DRIVEN = (*_FOLLOWING, EFFORT)


def offered_commands(model: RobotModel, joint: str) -> tuple[str, ...]:
    """Return what a joint can be commanded by: what its hardware declares, else everything."""
    if not model.joints[joint].active:
        return ()
    if not model.hardware:
        return COMMAND_INTERFACES
    declared = model.hardware_joints.get(joint, HardwareJoint(joint)).commands
    return tuple(kind for kind in declared if kind in COMMAND_INTERFACES)


def offered_states(model: RobotModel, joint: str) -> tuple[str, ...]:
    """Return what can be read of a joint: what its hardware declares, else everything."""
    measured = _DRIVEN if model.joints[joint].active else _FOLLOWING
    if not model.hardware:
        return measured
    declared = model.hardware_joints.get(joint, HardwareJoint(joint)).states
    return tuple(kind for kind in declared if kind in measured)


@dataclass(frozen=True, slots=True, eq=False)
class MockCommands:
    """
    Commands that are shifted, or that do not arrive.

    :param deaf: (m,) which drives get none, so that they hold.
    :param offset: (m,) added to positions [rad or m].
    """

    deaf: NDArray[np.bool_]
    offset: Vector

    @classmethod
    def of(cls, model: RobotModel) -> MockCommands | None:
        """Return those that the robot's hardware asks for, None where all arrive as they are."""
        if not any(system.deaf or system.offset for system in model.hardware):
            return None
        joints = {joint.name: system for system in model.hardware for joint in system.joints}
        systems = [joints.get(name) for name in model.active_joints]
        return cls(np.array([system is not None and system.deaf for system in systems]),
                   np.array([system.offset if system is not None else 0.0 for system in systems]))

    def arriving(self, given: JointArrays) -> JointArrays:
        """Return what arrives of commands, or of their feed-forward (m,)."""
        arrays = JointArrays(*(np.where(self.deaf, np.nan, given.of(kind))
                               for kind in COMMAND_INTERFACES))
        arrays.position[:] += self.offset
        return arrays


class Mode(IntEnum):
    """What a drive follows."""

    HOLD = 0
    POSITION = 1
    VELOCITY = 2
    EFFORT = 3


#: Interfaces that can be claimed together, and what the drive then follows.
MODES: dict[frozenset[str], Mode] = {
    frozenset(): Mode.HOLD,
    frozenset({POSITION}): Mode.POSITION,
    frozenset({POSITION, VELOCITY}): Mode.POSITION,
    frozenset({POSITION, VELOCITY, ACCELERATION}): Mode.POSITION,
    frozenset({POSITION, EFFORT}): Mode.POSITION,
    frozenset({VELOCITY}): Mode.VELOCITY,
    frozenset({EFFORT}): Mode.EFFORT,
}


def mode_of(joint: str, claim: frozenset[str]) -> Mode:
    """
    Return what a joint's drive follows.

    :param claim: interfaces that are claimed of it.
    :raises SimulationError: they cannot be followed together.
    """
    if claim in MODES:
        return MODES[claim]
    legal = ', '.join(
        '[' + ', '.join(name for name in COMMAND_INTERFACES if name in option) + ']'
        for option in MODES
        if option
    )
    names = ', '.join(sorted(claim))
    raise SimulationError(
        f"joint '{joint}' cannot follow [{names}] together; allowed: {legal}"
    )


@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """
    What the drives of n joints follow.

    :param claims: (n,) claimed interfaces.
    :param position: (n,) those that follow positions; ``velocity`` and ``effort`` likewise.
    :param velocity_given: (n,) whose velocities are claimed, beside positions or alone.
    :param effort_added: (n,) whose effort adds to the torque of following positions.
    """

    claims: tuple[frozenset[str], ...]
    position: Mask
    velocity: Mask
    effort: Mask
    velocity_given: Mask
    effort_added: Mask

    @classmethod
    def of(cls, joints: Sequence[str], claimed: Mapping[str, frozenset[str]]) -> Followed:
        """
        Return what the drives of joints follow; an unclaimed joint holds.

        :raises SimulationError: interfaces that cannot be followed together.
        """
        claims = tuple(claimed.get(name, frozenset()) for name in joints)
        modes = np.array([mode_of(*pair) for pair in zip(joints, claims, strict=True)],
                         dtype=np.int64)
        return cls(
            claims,
            modes == Mode.POSITION,
            modes == Mode.VELOCITY,
            modes == Mode.EFFORT,
            np.array([VELOCITY in claim for claim in claims], dtype=np.bool_),
            np.array([claim == {POSITION, EFFORT} for claim in claims], dtype=np.bool_),
        )

    def changed(self, other: Followed) -> Mask:
        """Return which joints (n,) have other claims than there."""
        pairs = zip(self.claims, other.claims, strict=True)
        return np.array([first != two for first, two in pairs], dtype=np.bool_)
