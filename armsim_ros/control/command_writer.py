# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
From reference and error to the commands of the claimed interfaces.

Sets with ``position`` forward the reference. ``velocity`` alone and ``effort`` alone close the
loop: ``u = ff_velocity_scale * v_d + PID(e, v_d - v)``, for effort plus the trajectory's effort.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from armsim_ros.config.joint_trajectory_controller import JointTrajectoryControllerParameters
from armsim_ros.control.hardware_interface import (
    ACCELERATION,
    COMMAND_INTERFACES,
    EFFORT,
    HardwareInterface,
    POSITION,
    VELOCITY,
)
from armsim_ros.control.pid import Pid

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Index = NDArray[np.intp] | slice


def compact(indices: Sequence[int]) -> Index:
    """Return a slice where indices run without gap: views cost less than copies."""
    first = indices[0]
    if list(indices) == list(range(first, first + len(indices))):
        return slice(first, first + len(indices))
    return np.array(indices, dtype=np.intp)


class CommandWriter:
    """
    Commands of one trajectory controller.

    :param parameters: joints, command interfaces, gains.
    :param hardware: whose command arrays are written.
    """

    def __init__(
        self, parameters: JointTrajectoryControllerParameters, hardware: HardwareInterface
    ) -> None:
        """Look up where each value goes."""
        commanded = parameters.command_joints or parameters.joints
        self._columns = compact([parameters.joints.index(name) for name in commanded])
        self._target = compact([hardware.index[name] for name in commanded])
        self._hardware = hardware
        self._joints = len(parameters.joints)
        self._kinds = tuple(kind for kind in COMMAND_INTERFACES
                            if kind in parameters.command_interfaces)  # fmt: skip
        self._commanded = commanded
        self.forwards_position = POSITION in self._kinds
        self._feeds_forward = self.forwards_position and EFFORT not in self._kinds
        self._closed_loop = parameters.uses_pid and not (
            parameters.open_loop_control and self._kinds == (VELOCITY,)
        )
        self._pids = [Pid(parameters.gains[name]) for name in commanded]
        self._column_list = [parameters.joints.index(name) for name in commanded]
        self._scales = np.array([parameters.gains[n].ff_velocity_scale for n in commanded])
        self._closed = np.zeros(len(commanded))

    def set_gains(self, parameters: JointTrajectoryControllerParameters) -> None:
        """Take new gains over without a step of the integral part."""
        for i, (name, pid) in enumerate(zip(self._commanded, self._pids, strict=True)):
            gains = parameters.gains[name]
            pid.set_gains(gains)
            self._scales[i] = gains.ff_velocity_scale

    def reset(self) -> None:
        """Forget the integral parts."""
        for pid in self._pids:
            pid.reset()

    def write(self, ahead: Matrix, error: Matrix, output: Matrix, period: float) -> None:
        """
        Write the commands of one update.

        :param ahead: (3 or 4, n) reference one period ahead.
        :param error: (3, n) reference minus feedback now.
        :param output: (4, n) what is commanded, for the state message; written in place.
        :param period: [s].
        """
        columns, target = self._columns, self._target
        if self._closed_loop:
            self._close_loop(ahead, error, period)
            row = COMMAND_INTERFACES.index(self._kinds[0])
            output[row, columns] = self._closed
            self._hardware.command.of(self._kinds[0])[target] = self._closed
            return
        command = self._hardware.command
        for kind in self._kinds:
            row = COMMAND_INTERFACES.index(kind)
            values = ahead[row, columns]
            output[row, columns] = values
            command.of(kind)[target] = values
        if self._feeds_forward:
            feedforward = self._hardware.feedforward
            feedforward.velocity[target] = ahead[1, columns]
            feedforward.acceleration[target] = ahead[2, columns]

    def last_positions(self) -> Vector:
        """Return the position commands that stand (n,), NaN for joints without [rad or m]."""
        positions = np.full(self._joints, np.nan)
        if self.forwards_position:
            positions[self._columns] = self._hardware.command.position[self._target]
        return positions

    def release(self) -> None:
        """Stop all but positions, which stay where they are."""
        for kind in self._kinds:
            if kind in (VELOCITY, ACCELERATION, EFFORT):
                self._hardware.command.of(kind)[self._target] = 0.0
        self._hardware.feedforward.velocity[self._target] = np.nan
        self._hardware.feedforward.acceleration[self._target] = np.nan

    def _close_loop(self, ahead: Matrix, error: Matrix, period: float) -> None:
        closed = self._closed
        positions, velocities = error[0].tolist(), error[1].tolist()
        for i, (column, pid) in enumerate(zip(self._column_list, self._pids, strict=True)):
            closed[i] = pid.compute(positions[column], velocities[column], period)
        closed += self._scales * ahead[1, self._columns]
        if self._kinds == (EFFORT,):
            closed += ahead[3, self._columns]
