# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The gpio controller: sets command interfaces by name, and publishes states.

They are those of gpios; of joints and sensors where the parameters name them.

``receive`` may be called from any thread; all else belongs to the control loop.
"""

from __future__ import annotations

from collections.abc import Sequence
import math
from typing import ClassVar

import numpy as np

from armsim_ros.config.base import Settings
from armsim_ros.config.controllers.command_controllers import GpioCommandControllerParameters
from armsim_ros.control.broadcaster import SensorBroadcaster
from armsim_ros.control.command_writer import CommandTargets
from armsim_ros.control.mailbox import Mailbox, RepeatedWarning, STREAM_CAPACITY
from armsim_ros.errors import ControllerError, nearest

Group = tuple[str, Sequence[str], Sequence[float]]


class GpioCommandController(SensorBroadcaster):
    """``gpio_controllers/GpioCommandController``; what is not a command changes nothing."""

    parameters_class: ClassVar[type[Settings]] = GpioCommandControllerParameters
    only_reads: ClassVar[bool] = False

    @property
    def _own(self) -> GpioCommandControllerParameters:
        parameters = self.parameters
        assert isinstance(parameters, GpioCommandControllerParameters)
        return parameters

    @property
    def gpios(self) -> tuple[str, ...]:
        """What is commanded or published."""
        return self._own.gpios

    @property
    def joints(self) -> tuple[str, ...]:
        """Joints whose motion is commanded."""
        return self.moved_joints

    @property
    def required_command_interfaces(self) -> tuple[str, ...]:
        """Those that the parameters name."""
        return tuple('/'.join(target) for target in self._own.targets)

    @property
    def interfaces(self) -> tuple[str, ...]:
        """State interfaces that are published: those that are named, else all of the gpios."""
        if self._own.states:
            return self._own.states
        hardware = self.context.hardware
        return tuple(f'{gpio}/{kind}' for gpio in self._own.gpios if gpio not in hardware.index
                     for kind in hardware.states_of(gpio))

    def configure(self) -> None:
        """Check whether there is anything to command or to publish."""
        super().configure()
        self._warning = RepeatedWarning(self.events)
        if not (self.required_command_interfaces or self.interfaces):
            raise ControllerError(
                f"'{self.name}' names no interfaces, and the hardware has no gpio "
                f"{' or '.join(self._own.gpios)}")

    def activate(self, time_ns: int) -> None:
        """Take joints over without moving them, and forget what came before."""
        super().activate(time_ns)
        CommandTargets(self._own.targets, self.context.hardware).take_over()
        self._inbox: Mailbox[dict[tuple[str, str], float]] = Mailbox(
            self.context.wake, capacity=STREAM_CAPACITY)

    def receive(self, groups: Sequence[Group]) -> str:
        """
        Take a command; while inactive it is dropped without a word.

        :param groups: (gpio, interface names, values); only those that are named are set.
        :returns: why it was dropped as a whole, '' where it was taken.
        """
        if not self.active:
            return 'the controller is not active'
        if obstacle := self.obstacle:
            return self.drop(obstacle)
        targets = self._own.targets
        found: dict[tuple[str, str], float] = {}
        for gpio, names, values in groups:
            if len(names) != len(values):
                return self.drop(f"'{gpio}' has {len(names)} interface names and "
                                  f'{len(values)} values')
            for name, value in zip(names, values, strict=True):
                interface = f'{gpio}/{name}'
                if not math.isfinite(value):
                    return self.drop(f'{value} for {interface}')
                if (gpio, name) in targets:
                    found[gpio, name] = value
                else:
                    known = self.required_command_interfaces
                    hint = nearest(interface, known) or f'known: {", ".join(known) or "none"}'
                    self._warning.add(self.time_ns, f"'{interface}' is not commanded; {hint}")
        self._inbox.post(found)
        return ''

    def update(self, time_ns: int, period: float) -> None:
        """Set what was commanded, then sample the states."""
        for command in self._inbox.take_all():
            CommandTargets(list(command), self.context.hardware).write(
                np.array(list(command.values())))
        super().update(time_ns, period)

    def next_update(self, time_ns: int) -> int:
        """Return when an update matters [ns]: when there is a command or a sample."""
        return time_ns if self._inbox else super().next_update(time_ns)

    def drop(self, reason: str) -> str:
        """Warn, now and then, of a command that is not followed."""
        self._warning.add(self.time_ns, f'command dropped: {reason}')
        return reason
