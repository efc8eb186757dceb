# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What parameters of mock hardware do to commands on their way to the drives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Vector
from armsim_ros.control.hardware_interface import COMMAND_INTERFACES, JointArrays
from armsim_ros.model.robot_model import RobotModel


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
