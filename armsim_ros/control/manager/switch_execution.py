# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Carries switches out in the control loop's thread, and knows which controllers are updated.

A switch first passes the interfaces that will be claimed to the hardware; if the hardware refuses,
nothing has changed. Then controllers are stopped, then others started, between two updates.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from typing import Any

import numpy as np

from armsim_ros.config.controllers.controller_manager import ControllerManagerParameters
from armsim_ros.control.controller import Controller, LifecycleState
from armsim_ros.control.hardware_interface import POSITION
from armsim_ros.control.mailbox import EventQueue
from armsim_ros.control.manager.manager_info import (
    dependencies,
    depends_on,
    group_of,
    in_order,
    preceding,
    withdraw,
)
from armsim_ros.control.manager.resources import Resources
from armsim_ros.control.manager.switching import (
    claimed_joints,
    plan_switch,
    plan_takeover,
    Strictness,
    SwitchResult,
    takeover_obstacles,
)
from armsim_ros.errors import ArmsimError, ControllerError


class UpdatesAhead:
    """
    The next updates of a manager, by their number from 0.

    :param active: controllers, each with the manager's updates per update of its own.
    :param tick: number of the first update since the manager began.
    :param time_ns: its time [ns].
    :param period: from each to the next [s].
    """

    def __init__(
        self, active: Sequence[tuple[Controller[Any], int]], tick: int, time_ns: int, period: float
    ) -> None:
        self._readers = [entry for entry in active if entry[0].only_reads]
        self._others = [entry for entry in active if not entry[0].only_reads]
        self._tick, self._time_ns, self._period = tick, time_ns, period

    def plan(self, updates: int, *, moving: bool) -> int:
        """Plan updates, see :meth:`Controllers.plan`."""
        planners: list[Controller[Any]] = []
        for controller, divisor in self._others:
            if (wait := self._wait(controller, 0)) > 0:
                updates = min(updates, wait)
            elif moving and divisor == 1:
                planners.append(controller)
            else:
                return 0
        if moving and not planners:
            return 0
        for controller in planners:
            updates = updates and controller.plan(updates, self._period)
        return updates

    def next_reading(self, update: int, updates: int) -> int:
        """Return when states are read, see :meth:`Controllers.next_reading`."""
        for controller, divisor in self._readers:
            first = update + self._wait(controller, update)
            # Its updates are those whose numbers are multiples of the divisor.
            updates = min(updates, first + -(self._tick + first) % divisor)
        return updates

    def read(self, update: int, failures: dict[str, Exception]) -> None:
        """
        Update the controllers that only read states.

        :param failures: controller -> what it has raised; those that have are left out.
        """
        time_ns = self.time_ns(update)
        for controller, divisor in self._readers:
            if (self._tick + update) % divisor or controller.name in failures:
                continue
            try:
                controller.update(time_ns, self._period * divisor)
            except Exception as error:  # noqa: BLE001 - one controller must not stop the others
                failures[controller.name] = error

    def time_ns(self, update: int) -> int:
        """Return the time of an update [ns]."""
        return self._time_ns + round(update * self._period * 1e9)

    def _wait(self, controller: Controller[Any], update: int) -> int:
        """Return how many updates from the present on do not matter to a controller."""
        period_ns = self._period * 1e9
        time_ns = self._time_ns + round(update * period_ns)
        return max(0, int(-((time_ns - controller.next_update(time_ns)) // period_ns)))


Controllers = Mapping[str, Controller[Any]]


#: Names of controllers, or what returns them when the request is carried out.
Names = Sequence[str] | Callable[[], Sequence[str]]


class SwitchRequest:
    """
    Controllers to start and to stop; 0 as strictness takes the manager's default.

    :param hardware_changed: whether the hardware has another state, and follows or ignores the
        active controllers from now on.
    :param future: gets the result.
    """

    __slots__ = ('_activate', '_deactivate', 'future', 'hardware_changed', 'strictness')

    def __init__(
        self, activate: Names = (), deactivate: Names = (),
        strictness: int = Strictness.BEST_EFFORT, *, hardware_changed: bool = False
    ) -> None:
        self.hardware_changed = hardware_changed
        self._activate, self._deactivate = activate, deactivate
        self.strictness = strictness
        self.future: Future[SwitchResult] = Future()

    def names(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Return which controllers to start and which to stop, once it is carried out."""
        activate, deactivate = (tuple(names() if callable(names) else names)
                                for names in (self._activate, self._deactivate))
        return activate, deactivate


class SwitchExecution:
    """
    Starts and stops controllers.

    :param resources: the hardware and its components' states.
    :param events: what happened, in words.
    """

    def __init__(
        self, resources: Resources, parameters: ControllerManagerParameters, events: EventQueue
    ) -> None:
        self.generation = 0
        self.active: tuple[tuple[Controller[Any], int], ...] = ()
        #: Controllers that no client sees, see ``attach``.
        self.devices: tuple[tuple[Controller[Any], int], ...] = ()
        self._hardware = resources.hardware
        self._resources, self._parameters, self._events = resources, parameters, events

    def execute(
        self, controllers: Controllers, request: SwitchRequest, time_ns: int
    ) -> SwitchResult:
        """
        Carry a request out as far as its strictness allows.

        :param controllers: all that are loaded.
        """
        strict = self._strict(request.strictness)
        try:
            plan = plan_switch(controllers, self._resources, *request.names(), strict=strict)
        except ControllerError as error:
            return SwitchResult(False, f'nothing was switched: {error}')
        if not (plan.activate or plan.deactivate):
            if request.hardware_changed:
                self._follow_hardware(controllers, time_ns)
            return SwitchResult(True, '; '.join(['nothing to do', *plan.left_out]))
        failures = self._switch(controllers, plan.activate, plan.deactivate, time_ns,
                                strict=strict)
        message = '; '.join([*failures, *plan.left_out]) or 'controllers switched'
        return SwitchResult(not failures, message)

    def attach(self, device: Controller[Any], time_ns: int) -> None:
        """Have a device, which is configured, command its joints where no controller does."""
        self.devices = (*self.devices, (device, 1))
        self._hardware.device_joints.update(device.joints)
        self._follow_devices()
        self.follow_hardware([controller for controller, _ in self.active], time_ns)
        self._activate(device, time_ns)

    def detach_failed(self, name: str, error: Exception, time_ns: int) -> None:
        """Let go of a device that raised."""
        self.devices = tuple(entry for entry in self.devices if entry[0].name != name)
        self._events.add(time_ns, 'error', 'failure',
                         f"'{name}' failed and is left out: {error.__class__.__name__}: {error}")

    def replace_failed(
        self, controllers: Controllers, failed: Controller[Any], error: Exception, time_ns: int
    ) -> None:
        """
        Deactivate a controller that raised, and activate its fallback controllers.

        All of its chain is deactivated with it, and what holds interfaces of the fallback
        controllers.
        """
        text = f"'{failed.name}' failed and is deactivated: {error.__class__.__name__}: {error}"
        self._events.add(time_ns, 'error', 'failure', text)
        chain = [member for member in group_of(failed, controllers.values()) if member.active]
        plan = plan_takeover(controllers, chain)
        failures = takeover_obstacles(controllers, self._resources, plan)
        starting = () if failures else plan.activate
        failures += self._switch(controllers, starting, plan.deactivate, time_ns, strict=True)
        if failed.active:  # the hardware refuses the interfaces of the fallback controllers
            failures += self._switch(controllers, (), plan.deactivate, time_ns, strict=True)
        active = [name for name in starting if controllers[name].active]
        if results := [*plan.left_out, *failures,
                       *([f'active: {", ".join(active)}'] if active else [])]:
            self._events.add(time_ns, 'warning', 'state', f'fallback: {"; ".join(results)}')

    def follow_hardware(self, active: Sequence[Controller[Any]], time_ns: int) -> None:
        """Have the hardware follow active controllers, as far as their joints are not idle."""
        self._follow_hardware({controller.name: controller for controller in active}, time_ns)

    def start_anew(self, controllers: Sequence[Controller[Any]], time_ns: int) -> None:
        """Have active controllers take over the joints where they are."""
        for controller in controllers:
            if self._activate(controller, time_ns):
                self._refresh({entry.name: entry for entry, _ in self.active})

    def _follow_hardware(self, controllers: Controllers, time_ns: int) -> None:
        """Have the hardware follow the active controllers, where it is active itself."""
        active = [controller for controller in controllers.values() if controller.active]
        try:
            self._resources.perform_command_mode_switch(self._claims(active))
        except ArmsimError as error:
            self._events.add(time_ns, 'error', 'failure', str(error))

    def _switch(
        self, controllers: Controllers, activate: Sequence[str], deactivate: Sequence[str],
        time_ns: int, *, strict: bool
    ) -> list[str]:
        """
        Stop and start controllers; those whose references get or lose a writer start anew.

        :returns: failures; with ``strict`` none that was to start is active then.
        """
        stopping = [controllers[name] for name in deactivate]
        starting = [controllers[name] for name in activate]
        staying = [controller for controller in controllers.values() if controller.active
                   and controller not in stopping]
        requested = [*staying, *starting]
        restarting = [controller for controller in staying
                      if bool(preceding(controller, requested)) != controller.chained]
        starting = in_order([*starting, *restarting], depends_on)[::-1]
        try:
            if any(controller.required_command_interfaces for controller in (
                    *stopping, *starting)):
                self._resources.perform_command_mode_switch(self._claims(requested))
        except ArmsimError as error:
            return [f'nothing was switched: {error}']
        for controller in in_order([*stopping, *restarting], depends_on):
            self._deactivate(controller, time_ns)
        self._forget_positions(requested)
        for controller in requested:
            controller.chained = bool(preceding(controller, requested))
        failures = [text for controller in starting
                    if (text := self._start(controller, controllers, time_ns))]
        if failures:
            if strict:
                active = [controller for controller in starting if controller.active]
                for controller in in_order(active, depends_on):
                    self._deactivate(controller, time_ns)
                if active:
                    names = ', '.join(f"'{controller.name}'" for controller in active)
                    failures.append(f'deactivated again: {names}')
            failures += self._open_chains([controller for controller in requested
                                           if controller.active], time_ns)
            self._follow_hardware(controllers, time_ns)
        self._refresh(controllers)
        return failures

    def _open_chains(self, active: Sequence[Controller[Any]], time_ns: int) -> list[str]:
        """Restart controllers whose references have lost their writer; return failures."""
        failures = []
        for controller in in_order(active, depends_on)[::-1]:
            if controller.chained and not preceding(controller, active):
                self._deactivate(controller, time_ns)
                failures.append(self._activate(controller, time_ns))
        return [text for text in failures if text]

    def _start(self, controller: Controller[Any], controllers: Controllers, time_ns: int) -> str:
        """Activate a controller unless a controller that it depends on has failed to start."""
        for needed in dependencies(controller, controllers.values()):
            if not needed.active:
                return f"'{controller.name}' stays inactive without '{needed.name}'"
        return self._activate(controller, time_ns)

    def _activate(self, controller: Controller[Any], time_ns: int) -> str:
        try:
            controller.activate(time_ns)
        except Exception as error:  # noqa: BLE001 - the others of the request shall go on
            # As an error in on_activate: on_error leads to unconfigured.
            controller.state = LifecycleState.UNCONFIGURED
            withdraw(controller, self._hardware)
            text = f"'{controller.name}' could not be activated: {error}"
            self._events.add(time_ns, 'error', 'state', text)
            return text
        controller.state = LifecycleState.ACTIVE
        self._events.add(time_ns, 'info', 'state', f"'{controller.name}' is active")
        return ''

    def _deactivate(self, controller: Controller[Any], time_ns: int) -> None:
        controller.state = LifecycleState.INACTIVE
        controller.chained = False
        try:
            controller.deactivate(time_ns)
        except Exception as error:  # noqa: BLE001 - it must not stay active because it fails
            text = f"'{controller.name}' failed while it was deactivated: {error}"
            self._events.add(time_ns, 'error', 'failure', text)
        self._events.add(time_ns, 'info', 'state', f"'{controller.name}' is inactive")

    def _forget_positions(self, controllers: Sequence[Controller[Any]]) -> None:
        """Erase position commands that grow old while another interface moves the joint."""
        for joint, kinds in self._claims(controllers).items():
            if POSITION not in kinds:
                self._hardware.command.position[self._hardware.index[joint]] = np.nan

    def _claims(self, controllers: Sequence[Controller[Any]]) -> dict[str, frozenset[str]]:
        idle = self._resources.idle_joints
        claims = claimed_joints(controllers, self._hardware)
        for name in idle:
            claims.pop(name, None)
        for device, _ in self.devices:
            for name in device.joints:
                if name not in idle:
                    claims.setdefault(name, frozenset({POSITION}))
        # What brakes a stopped arm commands positions.
        claims.update((name, frozenset({POSITION})) for name in self._resources.halted)
        return claims

    def _refresh(self, controllers: Controllers) -> None:
        rate = self._parameters.update_rate
        self.active = tuple(
            (controller, round(rate / controller.update_rate))
            for controller in in_order([controller for controller in controllers.values()
                                        if controller.active]))
        self._follow_devices()
        self.generation += 1

    def _follow_devices(self) -> None:
        for device, _ in self.devices:
            device.holder = next((
                controller.name for controller, _ in self.active
                if not set(device.joints).isdisjoint(controller.moved_joints)), '')

    def _strict(self, strictness: int) -> bool:
        if strictness == 0:
            return self._parameters.defaults.switch_controller.strictness == 'strict'
        return strictness == Strictness.STRICT
