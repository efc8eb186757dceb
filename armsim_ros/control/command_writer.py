# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From reference and error to the commands of the claimed interfaces; PID with anti-windup."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
import math

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Matrix, selector, Vector
from armsim_ros.config.controllers.joint_trajectory_controller import (
    JointTrajectoryControllerParameters,
)
from armsim_ros.config.controllers.pid_controller import PidGains
from armsim_ros.control.hardware_interface import (
    ACCELERATION,
    COMMAND_INTERFACES,
    EFFORT,
    HardwareInterface,
    JointArrays,
    POSITION,
    VELOCITY,
)


class Pid:
    """
    ``u = p*e + I + d*de`` within its bounds.

    ``I`` is the integral part. How it is kept from winding up is the gains'
    ``antiwindup_strategy``: ``legacy`` bounds it by the i clamps, ``back_calculation`` bleeds it
    by what the output bounds cut off, ``conditional_integration`` stops it while the output is
    saturated and the error would drive it further, ``none`` lets it grow. The clamps hold for
    every strategy.
    """

    __slots__ = ('_deadband', '_gains', '_integral', '_lower', '_output', '_strategy',
                 '_time_constant', '_upper')

    def __init__(self, gains: PidGains) -> None:
        self._integral = 0.0
        self._output = 0.0
        self.set_gains(gains)

    def set_gains(self, gains: PidGains) -> None:
        """Change the gains; the integral part is kept as far as its new bounds allow."""
        self._gains = gains
        self._lower, self._upper = gains.integral_bounds
        self._strategy = gains.antiwindup_strategy
        self._deadband = gains.error_deadband
        self._time_constant = gains.tracking_time_constant or _time_constant(gains)
        self._integral = min(max(self._integral, self._lower), self._upper)

    @property
    def integral(self) -> float:
        """The integral part of the output."""
        return self._integral

    def reset(self) -> None:
        """Forget the integral part and the last output."""
        self._integral = 0.0
        self._output = 0.0

    def compute(self, error: float, error_rate: float, period: float) -> float:
        """
        Return the output for a period.

        :param error: desired minus measured [rad or m].
        :param error_rate: desired minus measured velocity [rad/s or m/s].
        :param period: [s]; 0 repeats the last output.
        :returns: NaN where an error is not finite, and the integral part stays as it was.
        """
        if period <= 0.0:
            return self._output
        if not (math.isfinite(error) and math.isfinite(error_rate)):
            return math.nan
        gains = self._gains
        linear = gains.p * error + gains.d * error_rate
        strategy = self._strategy
        step = gains.i * error * period if abs(error) > self._deadband else 0.0
        if strategy in ('legacy', 'none'):
            self._integral = min(max(self._integral + step, self._lower), self._upper)
        free = linear + self._integral
        output = min(max(free, gains.u_clamp_min), gains.u_clamp_max)
        if strategy == 'back_calculation':
            if gains.i:
                step += (output - free) * period / self._time_constant
            self._integral = min(max(self._integral + step, self._lower), self._upper)
        elif strategy == 'conditional_integration' and (output == free or error * free <= 0.0):
            self._integral = min(max(self._integral + step, self._lower), self._upper)
        self._output = output
        return output


def _time_constant(gains: PidGains) -> float:
    """Return sqrt(d / i), or p / i without d [s]: the usual choice for back calculation."""
    if gains.i == 0.0:
        return 1.0
    ratio = gains.d / gains.i if gains.d else (gains.p / gains.i) ** 2
    return math.sqrt(abs(ratio)) or 1.0


class CommandTargets:
    """
    Writes commands as they are: what a joint can do is the hardware's matter.

    :param targets: (owner, interface) of each of the m values of a command; an owner is a joint, a
        sensor or gpio, or a joint of a following controller.
    :param hardware: has them.
    """

    def __init__(self, targets: Sequence[tuple[str, str]], hardware: HardwareInterface) -> None:
        columns: dict[str, list[int]] = {}
        for column, target in enumerate(targets):
            motion = hardware.motion_of('/'.join(target))
            columns.setdefault(motion[1] if motion else '', []).append(column)
        others = ['/'.join(targets[column]) for column in columns.get('', ())]
        self._other_columns = selector(columns.pop('', []))
        self._others = [(hardware.store_of(name), name) for name in others]
        self._joints = [
            (
                kind, hardware.command.of(kind),
                selector([hardware.index[targets[column][0]] for column in places]),
                selector(places))
            for kind, places in columns.items()]

    def take_over(self) -> None:
        """Leave the joints to the drives, which hold them until a command comes."""
        for kind, command, places, _ in self._joints:
            if kind != POSITION:
                command[places] = np.nan

    def write(self, values: Vector) -> None:
        """Write a command (m,)."""
        for _, command, places, columns in self._joints:
            command[places] = values[columns]
        for (store, name), value in zip(
            self._others, values[self._other_columns].tolist(), strict=True
        ):
            store[name] = value

    def stop(self, *, effort: float = 0.0) -> None:
        """
        Stop velocities; positions and what is not a joint's stay as they are.

        :param effort: of joints that follow efforts, NaN leaves them to the drives.
        """
        for kind, command, places, _ in self._joints:
            if kind == VELOCITY:
                command[places] = 0.0
            elif kind == EFFORT:
                command[places] = effort


Index = NDArray[np.intp] | slice


def compact(indices: Sequence[int]) -> Index:
    """Return a slice where indices run without gap: views cost less than copies."""
    first = indices[0]
    if list(indices) == list(range(first, first + len(indices))):
        return slice(first, first + len(indices))
    return np.array(indices, dtype=np.intp)


class CommandWriter:
    """
    Commands of a trajectory controller.

    :param parameters: joints, command interfaces, gains.
    :param hardware: whose command arrays are written, or the references of following
        controllers where the commanded joints are those of controllers.
    """

    def __init__(
        self, parameters: JointTrajectoryControllerParameters, hardware: HardwareInterface
    ) -> None:
        commanded, joints = parameters.commanded, parameters.commanding
        self._columns = compact([parameters.joints.index(name) for name in joints])
        chained = parameters.chained
        self._hardware = hardware
        command, feedforward = hardware.command, hardware.feedforward
        if chained:
            command = feedforward = JointArrays.filled(len(commanded))
        self._command, self._feedforward = command, feedforward
        self._target = compact(
            [i if chained else hardware.index[name] for i, name in enumerate(commanded)])
        self._joints = len(parameters.joints)
        self._kinds = tuple(kind for kind in COMMAND_INTERFACES
                            if kind in parameters.command_interfaces)
        self._commanded = joints
        self._references = [
            (kind, [f'{name}/{kind}' for name in commanded]) for kind in self._kinds if chained]
        self.forwards_position = POSITION in self._kinds
        self._feeds_forward = (
            self.forwards_position and EFFORT not in self._kinds and not chained)
        self.closes_loop = parameters.uses_pid and not (
            parameters.open_loop_control and self._kinds == (VELOCITY,))
        """Whether the commands depend on the errors, so that every update matters."""
        rows = [COMMAND_INTERFACES.index(kind) for kind in self._kinds]
        self._routes = [
            (row, command.of(kind)) for row, kind in zip(rows, self._kinds, strict=True)]
        if self._feeds_forward:
            self._aside = [(1, feedforward.velocity), (2, feedforward.acceleration)]
        else:
            self._aside = []
        self._pids = [Pid(parameters.gains[name]) for name in joints]
        self._column_list = [parameters.joints.index(name) for name in joints]
        self._scales = np.array([parameters.gains[n].ff_velocity_scale for n in joints])
        self._closed = np.zeros(len(commanded))

    def set_gains(self, old: Mapping[str, PidGains], new: Mapping[str, PidGains]) -> None:
        """Take new gains over without a step of the integral part, here or in the drives."""
        for i, (name, pid) in enumerate(zip(self._commanded, self._pids, strict=True)):
            gains = new[name]
            pid.set_gains(gains)
            self._scales[i] = gains.ff_velocity_scale
        changed = {name: new[name] for name in self._commanded if new[name] != old[name]}
        if changed and self.forwards_position and not self._references:
            self._hardware.set_gains(changed)

    def reset(self) -> None:
        """Forget the integral parts."""
        for pid in self._pids:
            pid.reset()

    def write(self, ahead: Matrix, error: Matrix, output: Matrix, period: float) -> None:
        """
        Write the commands of an update.

        :param ahead: (3 or 4, n) reference a period ahead.
        :param error: (3, n) reference minus feedback now.
        :param output: (4, n) what is commanded, for the state message; written in place.
        :param period: [s].
        """
        columns, target = self._columns, self._target
        if self.closes_loop:
            self._close_loop(ahead, error, period)
            row = COMMAND_INTERFACES.index(self._kinds[0])
            output[row, columns] = self._closed
            self._command.of(self._kinds[0])[target] = self._closed
            self._pass_on()
            return
        for row, command in self._routes:
            values = ahead[row, columns]
            output[row, columns] = values
            command[target] = values
        for row, feedforward in self._aside:
            feedforward[target] = ahead[row, columns]
        self._pass_on()

    @property
    def plans(self) -> bool:
        """Whether commands can be planned: nothing but the reference goes into them."""
        return self._feeds_forward and len(self._hardware.plan) > 0

    def plan(self, coming: Matrix) -> int:
        """
        Write commands of the next updates; return how many there was room for.

        :param coming: (k + 1, 3, n) the reference at each of these updates, and at the next.
        """
        plan = self._hardware.plan
        count = min(len(coming) - 1, len(plan))
        for row, planned in enumerate((plan.position, plan.velocity, plan.acceleration)):
            planned[:count, self._target] = coming[1 : count + 1, row, self._columns]
        return count

    def write_planned(self, ahead: Matrix) -> None:
        """Write the commands of an update that was planned: (3, n) its reference."""
        for row, command in (*self._routes, *self._aside):
            command[self._target] = ahead[row, self._columns]

    def last_positions(self) -> Vector:
        """Return the position commands in effect (n,), NaN for joints without [rad or m]."""
        positions = np.full(self._joints, np.nan)
        if self.forwards_position:
            positions[self._columns] = self._command.position[self._target]
        return positions

    def release(self) -> None:
        """Stop all but positions, which stay where they are; forget all of chained ones."""
        if self._references:
            for kind in self._kinds:
                self._command.of(kind)[:] = np.nan
            return
        for kind in self._kinds:
            if kind in (VELOCITY, ACCELERATION, EFFORT):
                self._command.of(kind)[self._target] = 0.0
        self._feedforward.velocity[self._target] = np.nan
        self._feedforward.acceleration[self._target] = np.nan

    def _pass_on(self) -> None:
        """Write the commands to the references of following controllers."""
        for kind, names in self._references:
            values = self._command.of(kind).tolist()
            self._hardware.references.update(zip(names, values, strict=True))

    def _close_loop(self, ahead: Matrix, error: Matrix, period: float) -> None:
        closed = self._closed
        positions, velocities = error[0].tolist(), error[1].tolist()
        for i, (column, pid) in enumerate(zip(self._column_list, self._pids, strict=True)):
            closed[i] = pid.compute(positions[column], velocities[column], period)
        closed += self._scales * ahead[1, self._columns]
        if self._kinds == (EFFORT,):
            closed += ahead[3, self._columns]
