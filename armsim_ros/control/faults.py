# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Faults of joints on purpose, so that tests can make tolerances fail.

They lie between controllers and plant: a program that wants them wraps the hardware in a
:class:`FaultInjector` and runs the controllers through :class:`FaultyControllers`; one that does
not has none of this in its loop.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
import math
from typing import Protocol

import numpy as np

from armsim_ros.config.controllers.pid_gains import PidGains
from armsim_ros.config.joint_fault import JointFault
from armsim_ros.control.hardware_interface import COMMAND_INTERFACES, HardwareInterface
from armsim_ros.errors import ControllerError, nearest


class FaultInjector(HardwareInterface):
    """
    Hardware whose joints can be made to fail.

    :param hardware: the real one; its states are shared, its commands are written by
        :meth:`write`.
    """

    def __init__(self, hardware: HardwareInterface) -> None:
        super().__init__(hardware.joint_names)
        self.state = hardware.state
        self.effort_bound = hardware.effort_bound
        self.other_commands = hardware.other_commands
        self.given_states = hardware.given_states
        self.given_states_of_parts = hardware.given_states_of_parts
        self._hardware = hardware
        self.wake: Callable[[], object] = lambda: None
        self._faults: dict[str, JointFault] = {}
        self._written = self._faults

    @property
    def active(self) -> Mapping[str, JointFault]:
        """Joint -> its fault, for those that have one."""
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
        wanted = float(self.command.position[i]) + fault.bias
        if math.isnan(last):
            last = float(self.state.position[i])
        if fault.blocked:
            wanted = last if not math.isnan(wanted) else wanted
            for kind in ('velocity', 'effort'):
                if not math.isnan(target.command.of(kind)[i]):
                    target.command.of(kind)[i] = 0.0
        elif fault.lag:
            wanted = last + (wanted - last) * -math.expm1(-period / fault.lag)
        target.command.position[i] = wanted
        target.feedforward.velocity[i] = math.nan
        target.feedforward.acceleration[i] = math.nan


class Controllers(Protocol):
    """What a control loop calls; the controller manager is one."""

    def update(self, time_ns: int, period: float, /) -> object:
        """Read states and write commands for the next period [s]."""

    def process_requests(self, time_ns: int, /) -> object:
        """Take up switches, goals and cancels without moving time."""

    def interrupt(self, time_ns: int, reason: str) -> None:
        """End all goals before the plant is put elsewhere."""

    def resume(self, time_ns: int) -> None:
        """Have the active controllers take over the plant where it is now."""

    def next_update(self, time_ns: int) -> int:
        """Return from when on an update matters [ns]."""

    def plan(self, updates: int, time_ns: int, period: float) -> int:
        """Write position commands for updates ahead into the plan; return for how many."""

    def next_look(self, update: int, updates: int) -> int:
        """Return the next update of the plan that reads states, ``updates`` where none does."""

    def look(self, update: int) -> bool:
        """Have the states read at an update of the plan; return whether nobody failed."""

    def land(self, updates: int) -> None:
        """Be where so many updates of the plan have led."""

    def only_looks(self, time_ns: int) -> bool:
        """Return whether an update now would do nothing but read states."""

    def glance(self, time_ns: int, period: float) -> None:
        """Do an update of which nothing matters but that states are read."""

    def look_early(self, time_ns: int, period: float) -> object:
        """Have the states read; the update of this time is still to come."""

    def skip(self, updates: int, period: float) -> None:
        """Take note of updates that were left out, a period [s] apart."""

    def wake_with(self, wake: Callable[[], object]) -> None:
        """Have a function called when there is something new for the next update."""


class FaultyControllers:
    """Controllers whose commands pass through a fault injector."""

    def __init__(self, controllers: Controllers, faults: FaultInjector) -> None:
        self._controllers = controllers
        self._faults = faults

    def update(self, time_ns: int, period: float) -> None:
        """Run the controllers, then pass their commands on."""
        self._controllers.update(time_ns, period)
        self._faults.write(period)

    def process_requests(self, time_ns: int) -> None:
        """Take requests up while time stands still."""
        self._controllers.process_requests(time_ns)

    def interrupt(self, time_ns: int, reason: str) -> None:
        """End all goals."""
        self._controllers.interrupt(time_ns, reason)

    def resume(self, time_ns: int) -> None:
        """Have the active controllers take over the plant where it is now."""
        self._controllers.resume(time_ns)

    def next_update(self, time_ns: int) -> int:
        """Return from when on an update matters [ns]; at once while a joint fails."""
        return time_ns if self._faults.changing else self._controllers.next_update(time_ns)

    def plan(self, updates: int, time_ns: int, period: float) -> int:
        """Plan nothing: each update may fail."""
        return 0

    def next_look(self, update: int, updates: int) -> int:
        """Return ``updates``: nothing was planned."""
        return updates

    def look(self, update: int) -> bool:
        """Do nothing: nothing was planned."""
        return True

    def land(self, updates: int) -> None:
        """Do nothing: nothing was planned."""

    def only_looks(self, time_ns: int) -> bool:
        """Return whether an update now would do nothing but read states."""
        return not self._faults.changing and self._controllers.only_looks(time_ns)

    def glance(self, time_ns: int, period: float) -> None:
        """Have the states read, no command changes."""
        self._controllers.glance(time_ns, period)

    def look_early(self, time_ns: int, period: float) -> None:
        """Have the states read; the update of this time is still to come."""
        self._controllers.look_early(time_ns, period)

    def skip(self, updates: int, period: float) -> None:
        """Take note of updates that were left out."""
        self._controllers.skip(updates, period)

    def wake_with(self, wake: Callable[[], object]) -> None:
        """Have a function called when there is something new for the next update."""
        self._controllers.wake_with(wake)
        self._faults.wake = wake
