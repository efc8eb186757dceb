# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Commands kept within the URDF's limits, for ``enforce_command_limits``."""

from __future__ import annotations

import numpy as np

from armsim_ros.control.hardware_interface import (
    EFFORT,
    HardwareInterface,
    POSITION,
    VELOCITY,
)
from armsim_ros.control.joint_properties import JointProperties
from armsim_ros.model.robot_model import RobotModel


class CommandLimits:
    """
    Clips position, velocity and effort commands; what is not commanded stays NaN.

    :param model: gives the limits; without it nothing is clipped.
    """

    def __init__(self, hardware: HardwareInterface, model: RobotModel | None) -> None:
        self._command = hardware.command
        properties = JointProperties.of(hardware.joint_names, model)
        joints = model.joints if model is not None else {}
        effort = np.array(
            [joints[n].limits.effort if n in joints else np.inf for n in hardware.joint_names]
        )
        self._bounds = {
            POSITION: (properties.lower.copy(), properties.upper.copy()),
            VELOCITY: (-properties.velocity, properties.velocity.copy()),
            EFFORT: (-effort, effort),
        }
        if model is not None:
            self._narrow(model, hardware)

    def _narrow(self, model: RobotModel, hardware: HardwareInterface) -> None:
        """Take over what ``<ros2_control>`` says of limits: narrower ones, or none."""
        for name, joint in model.hardware_joints.items():
            i = hardware.index.get(name)
            if i is None:
                continue
            for kind, (lower, upper) in self._bounds.items():
                least, largest = joint.bounds.get(kind, (-np.inf, np.inf))
                lower[i], upper[i] = max(lower[i], least), min(upper[i], largest)
                if not joint.limited:
                    lower[i], upper[i] = -np.inf, np.inf

    def enforce(self) -> None:
        """Clip all commands in place."""
        for kind, (lower, upper) in self._bounds.items():
            values = self._command.of(kind)
            np.clip(values, lower, upper, out=values)
