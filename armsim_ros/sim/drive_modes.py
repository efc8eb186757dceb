# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a drive follows, by the interfaces that are claimed of its joint."""

from __future__ import annotations

from enum import IntEnum

from armsim_ros.control.hardware_interface import (
    ACCELERATION,
    COMMAND_INTERFACES,
    EFFORT,
    POSITION,
    VELOCITY,
)
from armsim_ros.errors import SimulationError


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
