# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Streamed commands kept within the limits of their joints, one interface at a time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.control.command_writer import compact
from armsim_ros.control.hardware_interface import (
    EFFORT,
    HardwareInterface,
    POSITION,
    VELOCITY,
)
from armsim_ros.control.joint_properties import JointProperties
from armsim_ros.model.robot_model import RobotModel

BRAKING_TIME = 0.15
"""From its velocity limit a joint is braked in so much time before a position limit [s]."""


class CommandGuard(ABC):
    """
    Brings the commands of one interface to the hardware.

    :param joints: (n,) names.
    :param hardware: has them.
    :param model: gives the limits; without it there are none.
    """

    def __init__(
        self, joints: Sequence[str], hardware: HardwareInterface, model: RobotModel | None
    ) -> None:
        self._hardware = hardware
        self._target = compact([hardware.index[name] for name in joints])
        self._limits = JointProperties.of(joints, model)

    @abstractmethod
    def start(self) -> None:
        """Take the joints over; nothing is written before a command comes."""

    @abstractmethod
    def accept(self, values: Vector) -> None:
        """Take a command (n,), finite."""

    @abstractmethod
    def write(self, period: float) -> bool:
        """Write the command of one update [s]; False where nothing changes any more."""

    @abstractmethod
    def time_out(self) -> None:
        """Come to rest, because no command has come for too long."""

    @abstractmethod
    def release(self) -> None:
        """Let go of the joints."""


class PositionGuard(CommandGuard):
    """Position commands within the limits, approached no faster than the velocity limit."""

    def start(self) -> None:
        """Leave the command that stands."""
        self._goal = self._reference()

    def accept(self, values: Vector) -> None:
        """Go there from now on."""
        self._goal = np.clip(values, self._limits.lower, self._limits.upper)

    def write(self, period: float) -> bool:
        """Move the command on by one step."""
        reference, step = self._reference(), self._limits.velocity * period
        following = reference + np.clip(self._goal - reference, -step, step)
        self._hardware.command.position[self._target] = following
        return bool((following != self._goal).any())

    def time_out(self) -> None:
        """Do nothing: an old position is still a place to be."""

    def release(self) -> None:
        """Do nothing: the last position stays."""

    def _reference(self) -> Vector:
        """Return the command that stands, else where the joints are."""
        standing = self._hardware.command.position[self._target]
        measured = self._hardware.state.position[self._target]
        return np.where(np.isfinite(standing), standing, measured)


class VelocityGuard(CommandGuard):
    """Velocity commands within the limits, braked before the joint's position ends."""

    def start(self) -> None:
        """Stand still until a command comes."""
        self._hardware.command.velocity[self._target] = np.nan
        self._wanted = np.zeros(len(self._limits.names))
        self._braking = np.minimum(self._limits.velocity, 1e6) / BRAKING_TIME

    def accept(self, values: Vector) -> None:
        """Move like that from now on."""
        bound = self._limits.velocity
        self._wanted = np.clip(values, -bound, bound)

    def write(self, period: float) -> bool:
        """Write the velocities that leave room to brake."""
        position = self._hardware.state.position[self._target]
        up = self._fastest(self._limits.upper - position, period)
        down = self._fastest(position - self._limits.lower, period)
        velocity = np.minimum(np.maximum(self._wanted, -down), up)
        self._hardware.command.velocity[self._target] = velocity
        return bool(self._wanted.any())

    def _fastest(self, room: Vector, period: float) -> Vector:
        """Return the velocity (n,) from which a joint can brake within its room [rad or m]."""
        left = np.maximum(room, 0.0)
        fastest: Vector = np.minimum(np.sqrt(2.0 * self._braking * left), left / period)
        return fastest

    def time_out(self) -> None:
        """Stop."""
        self._wanted = np.zeros_like(self._wanted)

    def release(self) -> None:
        """Stop."""
        self._hardware.command.velocity[self._target] = 0.0


class EffortGuard(CommandGuard):
    """Effort commands as they come; the drives bound them."""

    def start(self) -> None:
        """Leave the joints to the drives, which hold them."""
        self._hardware.command.effort[self._target] = np.nan
        self._wanted = np.full(len(self._limits.names), np.nan)

    def accept(self, values: Vector) -> None:
        """Push like that from now on."""
        self._wanted = values

    def write(self, period: float) -> bool:
        """Write the efforts."""
        self._hardware.command.effort[self._target] = self._wanted
        return False

    def time_out(self) -> None:
        """Let the drives hold the joints against gravity."""
        self._wanted = np.full_like(self._wanted, np.nan)

    def release(self) -> None:
        """Push no more."""
        self._hardware.command.effort[self._target] = 0.0


class OtherGuard(CommandGuard):
    """
    Commands of sensors, gpios and following controllers as they come; the last one stays.

    :param interfaces: (n,) as ``gpio/interface``.
    """

    def __init__(self, interfaces: Sequence[str], hardware: HardwareInterface) -> None:
        self._stores = [(hardware.store_of(name), name) for name in interfaces]

    def start(self) -> None:
        """Leave the commands that stand."""
        self._wanted: Sequence[float] = ()

    def accept(self, values: Vector) -> None:
        """Write this from now on."""
        self._wanted = values.tolist()

    def write(self, period: float) -> bool:
        """Write the values."""
        for (store, name), value in zip(self._stores, self._wanted, strict=False):
            store[name] = value
        return False

    def time_out(self) -> None:
        """Do nothing: an old value is still a value."""

    def release(self) -> None:
        """Do nothing: the last value stays."""


GUARDS: dict[str, type[CommandGuard]] = {
    POSITION: PositionGuard,
    VELOCITY: VelocityGuard,
    EFFORT: EffortGuard,
}


def guards_of(
    targets: Sequence[tuple[str, str]], hardware: HardwareInterface, model: RobotModel | None
) -> tuple[tuple[CommandGuard, list[int]], ...]:
    """
    Return the guards of a controller's commands, each with the places of its values.

    :param targets: (owner, interface) of each value of a command.
    """
    columns: dict[str, list[int]] = {}
    for column, (owner, kind) in enumerate(targets):
        columns.setdefault(kind if owner in hardware.index else '', []).append(column)
    others = columns.pop('', [])
    guards: list[tuple[CommandGuard, list[int]]] = [
        (GUARDS[kind]([targets[column][0] for column in chosen], hardware, model), chosen)
        for kind, chosen in columns.items()
    ]
    if others:
        names = ['/'.join(targets[column]) for column in others]
        guards.append((OtherGuard(names, hardware), others))
    return tuple(guards)
