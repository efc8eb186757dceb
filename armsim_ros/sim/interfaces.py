# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which interfaces of a joint controllers may claim and read."""

from __future__ import annotations

from armsim_ros.control.hardware_interface import (
    ACCELERATION,
    COMMAND_INTERFACES,
    EFFORT,
    POSITION,
    VELOCITY,
)
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
