# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Commands kept within the URDF's limits, for ``enforce_command_limits``.

The rules are those of joint_limits: of its range limiter, and of its soft limiter for joints with
a ``<safety_controller>``.
"""

from __future__ import annotations

from collections.abc import Callable
import math

import numpy as np

from armsim_ros.arrays import Mask, Vector
from armsim_ros.control.hardware_interface import (
    ACCELERATION,
    COMMAND_INTERFACES,
    EFFORT,
    HardwareInterface,
    JointProperties,
    POSITION,
    VELOCITY,
)
from armsim_ros.model.robot_model import RobotModel, SoftLimits

#: A joint that is farther outside of its bounds takes no velocity [rad or m].
_FAR_OUTSIDE = 0.002
#: Speed at which a joint outside of its soft bounds returns [rad/s or m/s].
_RETURN_SPEED = math.radians(1.0)
#: Soft bounds this close together, and a gain this small, are not there [rad or m, 1/s].
_NEGLIGIBLE = 1e-10

Range = tuple[Vector, Vector]


class CommandLimits:
    """
    Limits position, velocity, acceleration and effort commands; what is not commanded stays NaN.

    A position moves at most as far per update as the joint's velocity allows.

    :param model: gives the limits; without it nothing is limited.
    """

    def __init__(self, hardware: HardwareInterface, model: RobotModel | None) -> None:
        self._hardware = hardware
        names = hardware.joint_names
        properties = JointProperties.of(names, model)
        joints = model.joints if model is not None else {}
        self._lower, self._upper = properties.lower.copy(), properties.upper.copy()
        self._velocity = properties.velocity.copy()
        self._effort = np.array([joints[n].limits.effort if n in joints else np.inf
                                 for n in names])
        self._acceleration, self._deceleration = np.full((2, len(names)), np.inf)
        if model is not None:
            self._narrow(model)
        soft = [joints[name].soft_limits if name in joints else None for name in names]

        def of_soft(value: Callable[[SoftLimits], float], default: float) -> Vector:
            return np.array([default if limits is None else value(limits) for limits in soft])

        self._is_soft = np.array([limits is not None for limits in soft], dtype=bool)
        lower = np.maximum(of_soft(lambda limits: limits.lower, -np.inf), self._lower)
        upper = np.minimum(of_soft(lambda limits: limits.upper, np.inf), self._upper)
        bounded = np.isfinite(lower) & np.isfinite(upper) & (upper - lower > _NEGLIGIBLE)
        self._soft_lower = np.where(bounded, lower, -np.inf)
        self._soft_upper = np.where(bounded, upper, np.inf)
        self._k_position = of_soft(lambda limits: limits.k_position, 0.0)
        self._slows_down = (self._is_soft & bounded & (self._k_position > _NEGLIGIBLE)
                            & np.isfinite(self._lower) & np.isfinite(self._velocity))
        self._k_velocity = of_soft(lambda limits: limits.k_velocity, 0.0)
        self._before = {kind: np.full(len(names), np.nan) for kind in (POSITION, VELOCITY)}

    def _narrow(self, model: RobotModel) -> None:
        """Take the limits of ``<ros2_control>``: narrower than the URDF's, or none."""
        for name, joint in model.hardware_joints.items():
            i = self._hardware.index.get(name)
            if i is None:
                continue
            for kind, (least, largest) in joint.bounds.items():
                unlimited = least == -np.inf and largest == np.inf
                if kind == POSITION:
                    self._lower[i] = least if unlimited else max(self._lower[i], least)
                    self._upper[i] = largest if unlimited else min(self._upper[i], largest)
                elif kind == ACCELERATION:
                    self._acceleration[i], self._deceleration[i] = largest, abs(least)
                else:
                    values = self._velocity if kind == VELOCITY else self._effort
                    values[i] = np.inf if unlimited else min(values[i], abs(least), largest)
            if not joint.limited:
                self._lower[i], self._upper[i] = -np.inf, np.inf
                for values in (self._velocity, self._effort, self._acceleration,
                               self._deceleration):
                    values[i] = np.inf

    def reset(self) -> None:
        """Forget the last commands: the next ones are limited from the measured states."""
        for before in self._before.values():
            before[:] = np.nan

    def enforce(self, period: float) -> None:
        """
        Limit all commands in place.

        :param period: from an update to the next [s].
        """
        command, state = self._hardware.command, self._hardware.state
        slowest, fastest = self._soft_velocities()
        ranges = {
            POSITION: self._positions(slowest, fastest, period),
            VELOCITY: self._velocities(slowest, fastest, period),
            ACCELERATION: self._accelerations(),
            EFFORT: self._efforts(slowest, fastest),
        }
        limited: Mask = np.zeros(len(state.position), dtype=bool)
        for kind in COMMAND_INTERFACES:
            values, (low, high) = command.of(kind), ranges[kind]
            limited |= (values < low) | (values > high)
            np.clip(values, low, high, out=values)
        for kind, before in self._before.items():
            before[:] = command.of(kind)
        if limited.any():  # what was to come with the commands does not fit them any more
            for kind in COMMAND_INTERFACES:
                self._hardware.feedforward.of(kind)[limited] = np.nan

    def _reference(self) -> Vector:
        """Return the last position commands, else the measured positions."""
        before = self._before[POSITION]
        return np.where(np.isfinite(before), before, self._hardware.state.position)

    def _soft_velocities(self) -> Range:
        """Return the velocities that soft limits leave: the less, the nearer a bound is."""
        velocity, position = self._velocity, self._hardware.state.position
        slowest, fastest = -velocity, velocity.copy()
        soft = self._slows_down
        if not soft.any():
            return slowest, fastest
        reference = self._reference()
        far = (position < self._lower - _FAR_OUTSIDE) | (position > self._upper + _FAR_OUTSIDE)
        outside = (position < self._soft_lower) | (position > self._soft_upper)
        for values, bound in ((slowest, self._soft_lower), (fastest, self._soft_upper)):
            near = np.clip(self._k_position[soft] * (bound - reference)[soft],
                           -velocity[soft], velocity[soft])
            values[soft] = np.where(far[soft], 0.0, np.where(
                outside[soft], np.copysign(_RETURN_SPEED, near), near))
        return slowest, fastest

    def _positions(self, slowest: Vector, fastest: Vector, period: float) -> Range:
        state, before = self._hardware.state, self._reference()
        speed = np.where(np.isfinite(self._velocity), np.minimum(
            self._velocity, np.abs(state.velocity) + self._acceleration * period), np.inf)
        step = speed * period
        low = np.maximum(np.minimum(before - step, self._upper), self._lower)
        high = np.minimum(np.maximum(before + step, low), self._upper)
        soft = self._is_soft
        if soft.any():
            least, largest = self._soft_lower[soft], self._soft_upper[soft]
            soft_low = np.clip(before[soft] + slowest[soft] * period, least, largest)
            soft_high = np.clip(before[soft] + fastest[soft] * period, soft_low, largest)
            both_low = np.maximum(soft_low, low[soft])
            both_high = np.minimum(soft_high, high[soft])
            overlap = both_low <= both_high
            low[soft] = np.where(overlap, both_low, soft_low)
            high[soft] = np.where(overlap, both_high, soft_high)
        return low, high

    def _velocities(self, slowest: Vector, fastest: Vector, period: float) -> Range:
        state, requested = self._hardware.state, self._hardware.command.velocity
        position, bound = state.position, np.isfinite(self._velocity)
        low = np.maximum((self._lower - position) / period, -self._velocity)
        high = np.minimum((self._upper - position) / period, self._velocity)
        above, below = position > self._upper, position < self._lower
        stop = (above & ((requested >= 0.0) | (position > self._upper + _FAR_OUTSIDE))) | (
            below & ((requested <= 0.0) | (position < self._lower - _FAR_OUTSIDE)))
        low, high = np.where(stop, 0.0, low), np.where(stop, 0.0, high)
        before = self._before[VELOCITY]
        before = np.where(np.isfinite(before), before, state.velocity)
        change = self._acceleration * period
        low, high = np.maximum(before - change, low), np.minimum(before + change, high)
        low, high = np.minimum(low, high), np.maximum(low, high)
        change = np.where(self._is_soft, change, np.inf)
        least = np.clip(state.velocity - change, slowest, fastest)
        most = np.clip(state.velocity + change, slowest, fastest)
        low, high = np.clip(low, least, most), np.clip(high, least, most)
        return np.where(bound, low, -np.inf), np.where(bound, high, np.inf)

    def _accelerations(self) -> Range:
        requested = self._hardware.command.acceleration
        slows = requested * self._hardware.state.velocity < 0.0
        largest = np.where(slows & np.isfinite(self._deceleration), self._deceleration,
                           self._acceleration)
        return -largest, largest

    def _efforts(self, slowest: Vector, fastest: Vector) -> Range:
        state, effort = self._hardware.state, self._effort
        low, high = -effort, effort.copy()
        bound = np.isfinite(effort)
        low[bound & (((state.position <= self._lower) & (state.velocity <= 0.0))
                     | (state.velocity < -self._velocity))] = 0.0
        high[bound & (((state.position >= self._upper) & (state.velocity >= 0.0))
                      | (state.velocity > self._velocity))] = 0.0
        soft = self._is_soft & bound
        if soft.any():
            for values, speed, pick in ((low, slowest, np.maximum), (high, fastest, np.minimum)):
                damped = np.clip(self._k_velocity[soft] * (speed - state.velocity)[soft],
                                 -effort[soft], effort[soft])
                values[soft] = pick(damped, values[soft])
        return low, high
