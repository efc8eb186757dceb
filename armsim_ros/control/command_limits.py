# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Commands kept within the URDF's limits, for ``enforce_command_limits``."""

from __future__ import annotations

import numpy as np

from armsim_ros.control.hardware_interface import HardwareInterface
from armsim_ros.control.joint_properties import JointProperties
from armsim_ros.model.robot_model import RobotModel


class CommandLimits:
    """
    Clips position, velocity and effort commands; what is not commanded stays NaN.

    :param model: gives the limits; without it nothing is clipped.
    """

    def __init__(self, hardware: HardwareInterface, model: RobotModel | None) -> None:
        """Look the limits up."""
        self._command = hardware.command
        properties = JointProperties.of(hardware.joint_names, model)
        self._lower, self._upper = properties.lower, properties.upper
        self._velocity = properties.velocity
        joints = model.joints if model is not None else {}
        self._effort = np.array(
            [joints[n].limits.effort if n in joints else np.inf for n in hardware.joint_names]
        )

    def enforce(self) -> None:
        """Clip all commands in place."""
        command = self._command
        np.clip(command.position, self._lower, self._upper, out=command.position)
        np.clip(command.velocity, -self._velocity, self._velocity, out=command.velocity)
        np.clip(command.effort, -self._effort, self._effort, out=command.effort)
