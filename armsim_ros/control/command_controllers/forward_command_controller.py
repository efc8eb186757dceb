# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The forward command controllers: each message is a command.

``receive`` may be called from any thread; all else belongs to the control loop.
"""

from __future__ import annotations

from collections.abc import Sequence
import math
from typing import ClassVar

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.config.base import Settings
from armsim_ros.config.controllers.command_controllers import (
    ForwardCommandControllerParameters,
    ForwardParameters,
    JointEffortControllerParameters,
    JointGroupEffortControllerParameters,
    JointGroupPositionControllerParameters,
    JointGroupVelocityControllerParameters,
    JointPositionControllerParameters,
    JointVelocityControllerParameters,
    MultiInterfaceForwardCommandControllerParameters,
)
from armsim_ros.control.command_writer import CommandTargets
from armsim_ros.control.controller import Controller, NEVER_NS
from armsim_ros.control.mailbox import Mailbox, RepeatedWarning
from armsim_ros.errors import ControllerError


class ForwardController(Controller[ForwardParameters]):
    """
    Passes commands on; an invalid command keeps the last.

    Nothing is written before the first command after activation: the joints hold.
    """

    #: Whether a command is a single number instead of a list.
    single: ClassVar[bool] = False

    #: Whether velocities and efforts end with deactivation, not only with another controller.
    stops: ClassVar[bool] = False

    _command: Vector | None = None
    _deadline_ns: int | None = None

    @property
    def joints(self) -> tuple[str, ...]:
        """The commanded joints."""
        return tuple(dict.fromkeys(joint for joint, _ in self.parameters.targets))

    @property
    def required_command_interfaces(self) -> tuple[str, ...]:
        """The interface of each value."""
        return tuple(f'{joint}/{kind}' for joint, kind in self.parameters.targets)

    def configure(self) -> None:
        """Look whether everything is named that is needed."""
        missing = self.parameters.missing
        if missing:
            raise ControllerError(f"parameter '{missing}' of '{self.name}' is empty")
        self._warning = RepeatedWarning(self.events)
        self._inbox: Mailbox[Vector] = Mailbox(self.context.wake, capacity=1)

    def activate(self, time_ns: int) -> None:
        """Take the joints over and forget what came before."""
        self._targets = CommandTargets(self.parameters.targets, self.context.hardware)
        self._targets.take_over()
        self._forget()

    def deactivate(self, time_ns: int) -> None:
        """Forget the command; what stops velocities and efforts is the kind of controller."""
        if self.stops:
            self._targets.stop()
        self._forget()

    def receive(self, values: Sequence[float]) -> str:
        """
        Take a command; while inactive it is dropped without a word.

        :param values: a value per command interface [rad, m, rad/s, m/s, N*m or N].
        :returns: why it was dropped, '' where it was taken.
        """
        if not self.active:
            return 'the controller is not active'
        if obstacle := self.obstacle:
            return self._drop(obstacle, values)
        expected = len(self.parameters.targets)
        if len(values) != expected:
            return self._drop(f'{len(values)} values; expected {expected}', values)
        command = np.array(values, dtype=np.float64)
        finite = np.isfinite(command)
        if not finite.all():
            place = int(np.argmin(finite))
            return self._drop(f'{values[place]} for {self.required_command_interfaces[place]}',
                              values)
        self._inbox.post(command)
        return ''

    def update(self, time_ns: int, period: float) -> None:
        """Write the newest command."""
        self.time_ns = time_ns
        commands = self._inbox.take_all()
        if commands:
            self._command = commands[-1]
            timeout = self.parameters.command_timeout
            self._deadline_ns = time_ns + round(timeout * 1e9) if timeout else None
        elif self._deadline_ns is not None and time_ns >= self._deadline_ns:
            self._forget()
            self._targets.stop(effort=math.nan)
        if self._command is not None:
            self._targets.write(self._command)

    def next_update(self, time_ns: int) -> int:
        """Return from when on an update matters [ns]: when there is a command or a timeout."""
        if self._inbox:
            return time_ns
        return NEVER_NS if self._deadline_ns is None else self._deadline_ns

    def _forget(self) -> None:
        self._inbox.take_all()
        self._command = self._deadline_ns = None

    def _drop(self, reason: str, values: Sequence[float]) -> str:
        names = ', '.join(self.required_command_interfaces)
        text = f'command dropped: {reason}; a command has one finite value for each of {names}'
        self._warning.add(self.time_ns, text)
        return reason


class ForwardCommandController(ForwardController):
    """``forward_command_controller/ForwardCommandController``."""

    parameters_class: ClassVar[type[Settings]] = ForwardCommandControllerParameters


class MultiInterfaceForwardCommandController(ForwardController):
    """``forward_command_controller/MultiInterfaceForwardCommandController``."""

    parameters_class: ClassVar[type[Settings]] = MultiInterfaceForwardCommandControllerParameters


class JointGroupPositionController(ForwardController):
    """``position_controllers/JointGroupPositionController``."""

    parameters_class: ClassVar[type[Settings]] = JointGroupPositionControllerParameters


class JointGroupVelocityController(ForwardController):
    """``velocity_controllers/JointGroupVelocityController``."""

    stops: ClassVar[bool] = True
    parameters_class: ClassVar[type[Settings]] = JointGroupVelocityControllerParameters


class JointGroupEffortController(ForwardController):
    """``effort_controllers/JointGroupEffortController``."""

    stops: ClassVar[bool] = True
    parameters_class: ClassVar[type[Settings]] = JointGroupEffortControllerParameters


class JointPositionController(ForwardController):
    """ROS 1's ``position_controllers/JointPositionController``."""

    single = True
    parameters_class: ClassVar[type[Settings]] = JointPositionControllerParameters


class JointVelocityController(ForwardController):
    """ROS 1's ``velocity_controllers/JointVelocityController``."""

    single = True
    stops: ClassVar[bool] = True
    parameters_class: ClassVar[type[Settings]] = JointVelocityControllerParameters


class JointEffortController(ForwardController):
    """ROS 1's ``effort_controllers/JointEffortController``."""

    single = True
    stops: ClassVar[bool] = True
    parameters_class: ClassVar[type[Settings]] = JointEffortControllerParameters
