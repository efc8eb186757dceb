# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The drives of the joints: commands in, torques out, at the rate of the physics."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from armsim_ros.config.pid_gains import PidGains
from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.control.hardware_interface import (
    ACCELERATION,
    COMMAND_INTERFACES,
    EFFORT,
    JointArrays,
    POSITION,
    VELOCITY,
)
from armsim_ros.errors import SimulationError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.sim.inverse_dynamics import InverseDynamics
from armsim_ros.sim.joint_limits import DrivenLimits
from armsim_ros.sim.reference import CommandInterpolator

Vector = NDArray[np.float64]
Mask = NDArray[np.bool_]


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


class Servo:
    """
    One drive a joint: inverse dynamics of the reference plus PID on the error.

    The reference is a position for each physics step; its velocity and acceleration are the
    differences that the integrator itself makes of it, so that in free motion the plant lands
    on every reference. All arrays hold the active joints in the model's order.

    A velocity command moves the reference on; an effort command is the torque itself. An effort
    beside a position is added to the drive's own torque. An unclaimed joint holds its place.

    :param model: the robot.
    :param settings: timestep, servo.
    :param gains: joint -> gains of its controller; a block without any gain counts as none.
    """

    def __init__(
        self, model: RobotModel, settings: SimulationSettings, gains: Mapping[str, PidGains]
    ) -> None:
        """Prepare the arrays; all joints hold 0 until ``restart``."""
        self.joint_names = model.active_joints
        self.limits = DrivenLimits.of(model)
        self.dynamics = InverseDynamics(model, settings)
        self._settings = settings.servo
        self._timestep = settings.timestep
        self._set_gains(gains)
        count = len(self.joint_names)
        self._mode = np.zeros(count, dtype=np.int64)
        self._claims: list[frozenset[str]] = [frozenset()] * count
        self._velocity_given = self._effort_added = np.zeros(count, dtype=np.bool_)
        self._sort_modes()
        self._velocity_command = np.zeros(count)
        self._effort_command = np.zeros(count)
        self._reference_velocity = np.zeros(count)
        self._integral = np.zeros(count)
        self._measured = np.zeros(count)
        self.reference = np.zeros(count)
        self._target = np.zeros(count)
        self._interpolator = CommandInterpolator(self._target)
        self.restart(self._target)

    def restart(self, position: Vector) -> None:
        """Rest at a position (n,) [rad or m]; commands and integrals are forgotten."""
        self.reference = position.copy()
        self._measured = position.copy()
        self._target = position.copy()
        for values in (self._reference_velocity, self._integral):
            values[:] = 0.0
        self._velocity_command[:] = self._effort_command[:] = 0.0
        self._interpolator.restart(position, np.ones(len(position), dtype=np.bool_))
        self.dynamics.torques(position, self._reference_velocity, self._reference_velocity)

    def switch(self, claimed: Mapping[str, frozenset[str]]) -> None:
        """
        Follow other interfaces from now on.

        :param claimed: joint -> claimed interfaces.
        :raises SimulationError: interfaces that cannot be followed together; nothing changes.
        """
        claims = [claimed.get(name, frozenset()) for name in self.joint_names]
        for name, claim in zip(self.joint_names, claims, strict=True):
            if claim not in MODES:
                raise SimulationError(_refused_claim(name, claim))
        changed = np.array(
            [new != old for new, old in zip(claims, self._claims, strict=True)], dtype=np.bool_
        )
        rest = np.where(
            self._mode == Mode.EFFORT,
            self._measured,
            np.where(self._mode == Mode.VELOCITY, self.reference, self._target),
        )
        self._target = np.where(changed, rest, self._target)
        self._interpolator.restart(self._target, changed)
        for values in (self._velocity_command, self._effort_command, self._integral):
            values[changed] = 0.0
        self._claims = claims
        self._mode = np.array([MODES[claim] for claim in claims], dtype=np.int64)
        self._velocity_given = np.array([VELOCITY in claim for claim in claims], dtype=np.bool_)
        self._effort_added = np.array(
            [claim == {POSITION, EFFORT} for claim in claims], dtype=np.bool_
        )
        self._sort_modes()

    def write(self, command: JointArrays, feedforward: JointArrays, steps: int) -> None:
        """
        Take the commands of one control period.

        :param command: of the active joints; NaN leaves the joint where it is.
        :param feedforward: velocity and acceleration at the period's end, NaN where not known.
        :param steps: physics steps in the period.
        """
        follows = self._follows_position & np.isfinite(command.position)
        self._target = np.where(follows, command.position, self._target)
        velocity = acceleration = self._unknown
        if steps > 1:
            given = self._velocity_given
            velocity = np.where(given, command.velocity, feedforward.velocity)
            acceleration = np.where(given, command.acceleration, feedforward.acceleration)
            velocity = np.where(follows, velocity, np.nan)
            acceleration = np.where(follows, acceleration, np.nan)
        self._interpolator.command(
            self._target, velocity, acceleration, steps, steps * self._timestep
        )
        if self._any_velocity:
            bounded = np.clip(command.velocity, -self.limits.velocity, self.limits.velocity)
            usable = self._follows_velocity & np.isfinite(bounded)
            self._velocity_command = np.where(usable, bounded, 0.0)
        if self._any_effort:
            wanted = (self._follows_effort | self._effort_added) & np.isfinite(command.effort)
            self._effort_command = np.where(wanted, command.effort, 0.0)

    def torques(self, position: Vector, velocity: Vector) -> Vector:
        """
        Return the torques of the next physics step and move the reference on by it.

        :param position: (n,) measured [rad or m].
        :param velocity: (n,) measured [rad/s or m/s].
        :returns: (n,) [N*m or N] within the effort limits.
        """
        h = self._timestep
        self._measured = position
        following = self._next_reference(position)
        next_velocity = (following - self.reference) / h
        acceleration = (next_velocity - self._reference_velocity) / h
        if self._any_effort:
            free = self._follows_effort
            self.reference = np.where(free, position, self.reference)
            self._reference_velocity = np.where(free, velocity, self._reference_velocity)
            following = np.where(free, position + h * velocity, following)
            next_velocity = np.where(free, velocity, next_velocity)
            acceleration = np.where(free, 0.0, acceleration)
        torque = self.dynamics.torques(self.reference, self._reference_velocity, acceleration)
        if not self._settings.feedforward:
            torque = np.zeros_like(torque)
        torque += self._feedback(self.reference - position, self._reference_velocity - velocity)
        if self._any_effort:
            torque = np.where(self._follows_effort, 0.0, torque) + self._effort_command
        self.reference, self._reference_velocity = following, next_velocity
        bounded: Vector = np.minimum(np.maximum(torque, -self.limits.effort), self.limits.effort)
        return bounded

    def state_bytes(self) -> bytes:
        """Return all that the next torques depend on besides the plant, for a digest."""
        parts = (self.reference, self._reference_velocity, self._integral, self._target)
        return b''.join(part.tobytes() for part in parts)

    def stiffness_warnings(self) -> list[str]:
        """Return a line for each joint whose gains are too high for the timestep."""
        inertia, h = self.dynamics.joint_inertias(), self._timestep
        lines = []
        for i, name in enumerate(self.joint_names):
            if self._p[i] * h * h > inertia[i] or self._d[i] * h > 2.0 * inertia[i]:
                lines.append(
                    f"the gains of joint '{name}' (p {self._p[i]:g}, d {self._d[i]:g}) are too "
                    f'high for a timestep of {h:g} s and an inertia of {inertia[i]:.3g}; stable '
                    f'are p below {inertia[i] / h**2:.3g} and d below {2 * inertia[i] / h:.3g}'
                )
        return lines

    def _next_reference(self, position: Vector) -> Vector:
        """Return where the reference is one step later, within all limits."""
        h, limits = self._timestep, self.limits
        wanted = self._interpolator.advance()
        if self._any_velocity:
            moved = self.reference + h * self._velocity_command
            # The reference waits for a joint that is blocked, within reach of its effort.
            moved = np.minimum(np.maximum(moved, position - self._reach), position + self._reach)
            wanted = np.where(self._follows_velocity, moved, wanted)
        wanted = np.minimum(np.maximum(wanted, limits.lower), limits.upper)
        step = self._longest_step
        stepped: Vector = self.reference + np.minimum(
            np.maximum(wanted - self.reference, -step), step
        )
        return stepped

    def _feedback(self, error: Vector, velocity_error: Vector) -> Vector:
        """Return p*e + I + d*(v_d - v), with d raised to the damping ratio asked for."""
        d = self._d
        if self._settings.damping_ratio > 0.0:
            inertia = self.dynamics.joint_inertias()
            wanted = 2.0 * self._settings.damping_ratio * np.sqrt(self._p * inertia)
            d = np.maximum(d, np.minimum(wanted, inertia / self._timestep))
        output: Vector = self._p * error + d * velocity_error
        if self._integrates:
            self._integral += self._i * error * self._timestep
            np.clip(self._integral, self._i_low, self._i_high, out=self._integral)
            output += self._integral
        return output

    def _sort_modes(self) -> None:
        self._follows_position: Mask = self._mode == Mode.POSITION
        self._follows_velocity: Mask = self._mode == Mode.VELOCITY
        self._follows_effort: Mask = self._mode == Mode.EFFORT
        self._any_velocity = bool(self._follows_velocity.any())
        self._any_effort = bool(self._follows_effort.any() or self._effort_added.any())
        # A velocity command is bounded itself; its reference must keep up with a dragged joint.
        self._longest_step = np.where(
            self._follows_velocity, np.inf, self._timestep * self.limits.velocity
        )
        self._unknown = np.full(len(self.joint_names), np.nan)

    def _set_gains(self, gains: Mapping[str, PidGains]) -> None:
        chosen = []
        for name in self.joint_names:
            block = self._settings.gains.get(name) or gains.get(name)
            if block is None or not (block.p or block.i or block.d):
                block = self._settings.default_gains
            chosen.append(block)
        self._p = np.array([block.p for block in chosen], dtype=np.float64)
        self._i = np.array([block.i for block in chosen], dtype=np.float64)
        self._d = np.array([block.d for block in chosen], dtype=np.float64)
        bounds = np.array([block.integral_bounds for block in chosen], dtype=np.float64)
        self._i_low, self._i_high = bounds.reshape(-1, 2).T
        self._integrates = bool(((self._i != 0.0) & (self._i_low < self._i_high)).any())
        with np.errstate(divide='ignore'):
            reach = self.limits.effort / self._p
        self._reach = np.where(np.isfinite(reach), reach, np.inf)


def _refused_claim(joint: str, claim: frozenset[str]) -> str:
    legal = ', '.join(
        '[' + ', '.join(name for name in COMMAND_INTERFACES if name in option) + ']'
        for option in MODES
        if option
    )
    names = ', '.join(sorted(claim))
    return f"joint '{joint}' cannot follow [{names}] together; allowed: {legal}"
