# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What controllers see of the joints: states to read, commands to write."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

POSITION = 'position'
VELOCITY = 'velocity'
ACCELERATION = 'acceleration'
EFFORT = 'effort'
COMMAND_INTERFACES = (POSITION, VELOCITY, ACCELERATION, EFFORT)


@dataclass(frozen=True, slots=True, eq=False)
class JointArrays:
    """
    One value a joint and interface, changed in place; NaN where there is none.

    :param position: (n,) [rad or m].
    :param velocity: (n,) [rad/s or m/s].
    :param acceleration: (n,) [rad/s^2 or m/s^2].
    :param effort: (n,) [N*m or N].
    """

    position: Vector
    velocity: Vector
    acceleration: Vector
    effort: Vector

    @classmethod
    def filled(cls, count: int, value: float = np.nan) -> JointArrays:
        """Return arrays of length ``count``, each value ``value``."""
        return cls(*(np.full(count, value) for _ in range(4)))

    def of(self, interface: str) -> Vector:
        """Return the array of an interface by its name."""
        values: Vector = getattr(self, interface)
        return values


class HardwareInterface(ABC):
    """
    The joints of one robot.

    ``state`` is refreshed before the controllers run; ``command`` is read after them. A
    position command is where the joint shall be one control period later; ``feedforward``
    (velocity, acceleration) may be given with it and says how it moves there, NaN where the
    controller does not say.

    :param joint_names: (n,) all movable joints, mimic ones too; the order of all arrays.
    """

    def __init__(self, joint_names: tuple[str, ...]) -> None:
        """Make arrays for the joints; all commands are NaN (none)."""
        self.joint_names = joint_names
        self.index = {name: i for i, name in enumerate(joint_names)}
        self.state = JointArrays.filled(len(joint_names), 0.0)
        self.command = JointArrays.filled(len(joint_names))
        self.feedforward = JointArrays.filled(len(joint_names))

    @property
    @abstractmethod
    def command_interfaces(self) -> Mapping[str, tuple[str, ...]]:
        """Joint -> interfaces that can be claimed; a mimic joint has none."""

    @property
    @abstractmethod
    def state_interfaces(self) -> Mapping[str, tuple[str, ...]]:
        """Joint -> interfaces that can be read."""

    @abstractmethod
    def perform_command_mode_switch(self, claimed: Mapping[str, frozenset[str]]) -> None:
        """
        Take over a change of claims.

        :param claimed: joint -> interfaces claimed from now on; a joint that is not there is
            unclaimed and holds its position.
        :raises SimulationError: a set of interfaces that the joint cannot follow together.
        """
