# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Faults of joints on purpose, so that tests can make tolerances fail.

They are between controllers and plant: a program that needs them wraps the hardware in a
:class:`FaultInjector` and runs the controllers through :class:`FaultyControllers`; the loop of any
other program is without them.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
import math

import numpy as np

from armsim_ros.config.controllers.pid_controller import PidGains
from armsim_ros.config.simulation import JointFault
from armsim_ros.control.controllers import ManagerGroup
from armsim_ros.control.hardware_interface import COMMAND_INTERFACES, HardwareInterface
from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.errors import ControllerError, nearest


class FaultInjector(HardwareInterface):
    """
    Hardware whose joints can be made to fail.

    :param hardware: the real hardware; its states are shared, its commands are written by
        :meth:`write`.
    """

    def __init__(self, hardware: HardwareInterface) -> None:
        super().__init__(hardware.joint_names)
        self.state = hardware.state
        self.effort_bound = hardware.effort_bound
        self.other_commands = hardware.other_commands
        self.device_joints = hardware.device_joints
        self.gravity_compensated = hardware.gravity_compensated
        self.given_states = hardware.given_states
        self.given_states_of_parts = hardware.given_states_of_parts
        self._hardware = hardware
        self.wake: Callable[[], object] = lambda: None
        self._faults: dict[str, JointFault] = {}
        self._written = self._faults

    @property
    def active(self) -> Mapping[str, JointFault]:
        """Joint -> its fault, of those that have a fault."""
        return self._faults

    def set_fault(self, joint: str, fault: JointFault) -> None:
        """
        Make a joint fail from the next update on, or be well again; any thread.

        :raises ControllerError: an unknown joint.
        """
        if joint not in self.index:
            hint = nearest(joint, self.joint_names) or f'known: {", ".join(self.joint_names)}'
            raise ControllerError(f"no joint '{joint}' to make fail; {hint}")
        faults = {name: f for name, f in self._faults.items() if name != joint}
        if fault != JointFault():
            faults[joint] = fault
        self._faults = faults
        self.wake()

    def clear(self) -> None:
        """Make all joints well again; any thread."""
        self._faults = {}
        self.wake()

    @property
    def command_interfaces(self) -> Mapping[str, tuple[str, ...]]:
        """Those of the hardware."""
        return self._hardware.command_interfaces

    @property
    def state_interfaces(self) -> Mapping[str, tuple[str, ...]]:
        """Those of the hardware."""
        return self._hardware.state_interfaces

    @property
    def sensor_links(self) -> Mapping[str, str]:
        """Sensor of forces and torques -> the link on which it sits."""
        return self._hardware.sensor_links

    @property
    def other_states(self) -> Mapping[str, float]:
        """Those of the hardware."""
        return self._hardware.other_states

    def perform_command_mode_switch(self, claimed: Mapping[str, frozenset[str]]) -> None:
        """Pass a change of claims on; what the hardware forgets is forgotten here too."""
        self._hardware.perform_command_mode_switch(claimed)
        for kind in COMMAND_INTERFACES:
            self.command.of(kind)[np.isnan(self._hardware.command.of(kind))] = np.nan
            self.feedforward.of(kind)[np.isnan(self._hardware.feedforward.of(kind))] = np.nan
        fresh = np.isnan(self.command.position)
        self.command.position[fresh] = self._hardware.command.position[fresh]

    def tare(self, foreign: Collection[str] = ()) -> None:
        """Pass it on."""
        self._hardware.tare(foreign)

    def set_payload(self, link: str, mass: float, centre: Sequence[float]) -> None:
        """Pass a load on."""
        self._hardware.set_payload(link, mass, centre)

    def set_gains(self, gains: Mapping[str, PidGains]) -> None:
        """Pass gains on."""
        self._hardware.set_gains(gains)

    @property
    def changing(self) -> bool:
        """Whether commands change though the controllers' do not."""
        return bool(self._faults) or self._written is not self._faults

    def write(self, period: float) -> None:
        """Pass the commands on, those of failing joints changed; the control loop's thread."""
        target = self._hardware
        faults = self._written = self._faults
        before = {name: target.command.position[self.index[name]] for name in faults}
        for kind in COMMAND_INTERFACES:
            target.command.of(kind)[:] = self.command.of(kind)
            target.feedforward.of(kind)[:] = self.feedforward.of(kind)
        for name, fault in faults.items():
            self._spoil(self.index[name], fault, float(before.get(name, math.nan)), period)

    def _spoil(self, i: int, fault: JointFault, last: float, period: float) -> None:
        target = self._hardware
        requested = float(self.command.position[i]) + fault.bias
        if math.isnan(last):
            last = float(self.state.position[i])
        if fault.blocked:
            requested = last if not math.isnan(requested) else requested
            for kind in ('velocity', 'effort'):
                if not math.isnan(target.command.of(kind)[i]):
                    target.command.of(kind)[i] = 0.0
        elif fault.lag:
            requested = last + (requested - last) * -math.expm1(-period / fault.lag)
        target.command.position[i] = requested
        target.feedforward.velocity[i] = math.nan
        target.feedforward.acceleration[i] = math.nan


class FaultyControllers(ManagerGroup):
    """
    Controllers whose commands pass through a fault injector.

    :param managers: of the robots.
    :param faults: the hardware of all these managers.
    """

    def __init__(self, managers: Sequence[ControllerManager], faults: FaultInjector) -> None:
        super().__init__(managers)
        self._faults = faults

    def update(self, time_ns: int, period: float) -> None:
        """Run the controllers, then pass their commands on."""
        super().update(time_ns, period)
        self._faults.write(period)

    def plan(self, updates: int, time_ns: int, period: float, *, moving: bool) -> int:
        """Plan updates at rest only: a command that changes, or a fault, needs each of them."""
        if moving or self._faults.changing:
            return 0
        return super().plan(updates, time_ns, period, moving=moving)

    def wake_with(self, wake: Callable[[], object]) -> None:
        """Have a function called when there is something new for the next update."""
        super().wake_with(wake)
        self._faults.wake = wake
