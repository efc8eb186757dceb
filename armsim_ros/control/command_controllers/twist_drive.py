# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""An arm's own drive by twists of its tool, for clients that do not command joints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Vector
from armsim_ros.config.base import ControllerParameters, Settings
from armsim_ros.control.arm_dynamics import ArmDynamics
from armsim_ros.control.controller import Controller, ControllerContext, NEVER_NS
from armsim_ros.control.hardware_interface import JointProperties
from armsim_ros.control.mailbox import Mailbox, RepeatedWarning
from armsim_ros.errors import ControllerError

#: The arm stops so long after the last twist [ns].
TIMEOUT_NS = 100_000_000
#: Greatest acceleration of a joint [rad/s^2].
ACCELERATION = 10.0
#: Speeds of joints that add less than this to the tool's are left out [m or rad per rad].
DAMPING = 0.02


class TwistDrive(Controller[ControllerParameters]):
    """Moves the tool of an arm by twists in its own frame; a device of a controller manager."""

    parameters_class: ClassVar[type[Settings]] = ControllerParameters
    _joints: tuple[str, ...] = ()
    _arm: ArmDynamics
    _limits: JointProperties
    _places: NDArray[np.intp]
    #: Where the arm is commanded to be (n,); None while it is at rest [rad].
    _reference: Vector | None = None

    @classmethod
    def of(cls, name: str, joints: Sequence[str], tool: str, context: ControllerContext
           ) -> TwistDrive:
        """
        Return a configured drive.

        :param joints: (n,) of the arm.
        :param tool: the link that the twists move.
        :raises ControllerError: they are not a chain.
        """
        drive = cls(name, cls.__name__, ControllerParameters(), context)
        if context.model is None:
            raise ControllerError(f"'{name}' needs the robot's description")
        drive._joints = tuple(joints)
        drive._arm = ArmDynamics(context.model, joints, tool, '')
        drive._limits = JointProperties.of(joints, context.model)
        drive._places = np.array([context.hardware.index[joint] for joint in joints])
        return drive

    def on_init(self) -> None:
        """Have no twist."""
        self._inbox: Mailbox[Vector] = Mailbox(self.context.wake, 1)
        self._warning = RepeatedWarning(self.events)
        self._twist, self._velocity = np.zeros(6), np.zeros(0)
        self._last_ns = -TIMEOUT_NS

    def configure(self) -> None:
        """Do nothing; ``of`` has done it."""

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints of the arm."""
        return self._joints

    @property
    def moves_arm(self) -> bool:
        """True: it stops when the arm does."""
        return True

    def receive(self, twist: Vector) -> None:
        """Take a twist of the tool (6,), linear above angular; any thread [m/s, rad/s]."""
        if np.isfinite(twist).all() and not self.obstacle:
            self._inbox.post(twist)

    def activate(self, time_ns: int) -> None:
        """Rest."""
        self._inbox.take_all()
        self._reference, self._last_ns = None, time_ns - TIMEOUT_NS

    def deactivate(self, time_ns: int) -> None:
        """Rest."""
        self.activate(time_ns)

    def next_update(self, time_ns: int) -> int:
        """Return from when on an update matters [ns]: never at rest."""
        return time_ns if self._inbox or self._reference is not None else NEVER_NS

    def update(self, time_ns: int, period: float) -> None:
        """Command the joints that move the tool as the last twist has it."""
        self.time_ns = time_ns
        for twist in self._inbox.take_all():
            self._twist, self._last_ns = twist, time_ns
            if self.holder:
                self._warning.add(time_ns, f"twists are ignored while '{self.holder}' commands "
                                  'the arm; deactivate it')
        if self.holder:
            self.activate(time_ns)
            return
        late = time_ns - self._last_ns >= TIMEOUT_NS
        if self._reference is None:
            if late:
                return
            self._reference = self._begin()
            self._velocity = np.zeros(len(self._reference))
        wanted = np.zeros_like(self._velocity) if late else self._joint_velocity(self._reference)
        change = wanted - self._velocity
        change *= min(1.0, ACCELERATION * period / float(np.abs(change).max() or 1.0))
        velocity = self._velocity + change
        limits = self._limits
        reference = np.clip(self._reference + period * velocity, limits.lower, limits.upper)
        self._velocity = np.where(reference == self._reference + period * velocity, velocity, 0.0)
        self._reference = reference
        hardware, places = self.context.hardware, self._places
        hardware.command.position[places] = reference
        hardware.feedforward.velocity[places] = self._velocity
        if late and not self._velocity.any():
            hardware.feedforward.velocity[places] = np.nan
            self._reference = None

    def _begin(self) -> Vector:
        """Return where the joints are commanded to be, else where they are (n,) [rad]."""
        hardware, places = self.context.hardware, self._places
        commanded = hardware.command.position[places]
        found: Vector = np.where(
            np.isfinite(commanded), commanded, hardware.state.position[places])
        return found

    def _joint_velocity(self, position: Vector) -> Vector:
        """Return the velocities of the joints (n,) by damped least squares [rad/s]."""
        arm = self._arm
        arm.move(position, np.zeros_like(position))
        turn, jacobian = arm.pose[:3, :3], arm.jacobian()
        twist = np.concatenate((turn @ self._twist[:3], turn @ self._twist[3:]))
        gram = jacobian @ jacobian.T + DAMPING**2 * np.eye(6)
        velocity: Vector = jacobian.T @ np.linalg.solve(gram, twist)
        excess = float((np.abs(velocity) / self._limits.velocity).max())
        return velocity / max(1.0, excess)
