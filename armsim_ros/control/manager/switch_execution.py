# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Carries switches out in the control loop's thread, and knows which controllers are updated.

A switch first tells the hardware which interfaces will be claimed; if the hardware refuses,
nothing has changed. Then controllers are stopped, then others started, between two updates.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Future
from typing import Any

import numpy as np

from armsim_ros.config.controllers.controller_manager import ControllerManagerParameters
from armsim_ros.control.controller import Controller, LifecycleState
from armsim_ros.control.events import EventQueue
from armsim_ros.control.hardware_interface import HardwareInterface, POSITION
from armsim_ros.control.manager.chains import all_preceding, following, in_order, preceding
from armsim_ros.control.manager.hardware_component import Hardware
from armsim_ros.control.manager.switching import (
    claimed_joints,
    plan_switch,
    Strictness,
    SwitchResult,
)
from armsim_ros.errors import ArmsimError

Controllers = Mapping[str, Controller[Any]]


class SwitchRequest:
    """
    Controllers to start and to stop; 0 as strictness takes the manager's default.

    :param future: gets the result.
    """

    __slots__ = ('activate', 'deactivate', 'future', 'strictness')

    def __init__(
        self, activate: Sequence[str], deactivate: Sequence[str], strictness: int
    ) -> None:
        self.activate = tuple(activate)
        self.deactivate = tuple(deactivate)
        self.strictness = strictness
        self.future: Future[SwitchResult] = Future()


class SwitchExecution:
    """
    Starts and stops controllers.

    :param components: the hardware's own states.
    :param events: what happened, in words.
    """

    def __init__(
        self,
        hardware: HardwareInterface,
        components: Hardware,
        parameters: ControllerManagerParameters,
        events: EventQueue,
    ) -> None:
        self.generation = 0
        self.active: tuple[tuple[Controller[Any], int], ...] = ()
        self._hardware = hardware
        self._components = components
        self._parameters = parameters
        self._events = events

    def execute(
        self, controllers: Controllers, request: SwitchRequest, time_ns: int
    ) -> SwitchResult:
        """
        Carry a request out as far as its strictness allows.

        :param controllers: all that are loaded.
        """
        plan = plan_switch(controllers, self._hardware, request.activate, request.deactivate)
        problems, activate = list(plan.problems), plan.activate
        for name in activate:
            idle = self._components.idle_owner(controllers[name].required_command_interfaces)
            if idle is not None:
                problems.append(f"hardware '{idle.name}' is {idle.state.value}")
                activate = ()
                break
        if problems and self._strict(request.strictness):
            return SwitchResult(False, f'nothing was switched: {"; ".join(problems)}')
        if not (activate or plan.deactivate):
            return SwitchResult(True, '; '.join(['nothing to do', *problems]))
        stopping = in_order([controllers[name] for name in plan.deactivate])
        starting = in_order([controllers[name] for name in activate])[::-1]
        wanted = [c for c in controllers.values() if c.active and c not in stopping] + starting
        try:
            self._hardware.perform_command_mode_switch(self._claims(wanted))
        except ArmsimError as error:
            return SwitchResult(False, f'nothing was switched: {error}')
        for controller in stopping:
            self._deactivate(controller, time_ns)
        self._forget_positions(wanted)
        failures = self._settle_chains(wanted, time_ns)
        failures += [text for c in starting if (text := self._start(c, controllers, time_ns))]
        if failures:
            failures += self._settle_chains([c for c in wanted if c.active], time_ns)
            claims = self._claims([c for c in wanted if c.active])
            self._hardware.perform_command_mode_switch(claims)
        self._refresh(controllers, time_ns)
        message = '; '.join(failures + problems) or 'controllers switched'
        return SwitchResult(not failures, message)

    def replace_failed(
        self, controllers: Controllers, failed: Controller[Any], error: Exception, time_ns: int
    ) -> None:
        """
        Deactivate a controller that raised, and activate its fallback controllers.

        Those that write to its references are deactivated with it.
        """
        text = f"'{failed.name}' failed and is deactivated: {error.__class__.__name__}: {error}"
        self._events.add(time_ns, 'error', 'failure', text)
        entry = self._parameters.controllers.get(failed.name)
        fallbacks = entry.fallback_controllers if entry is not None else ()
        active = [one for one in controllers.values() if one.active]
        chain = [failed.name, *(one.name for one in all_preceding(failed, active))]
        request = SwitchRequest(fallbacks, chain, Strictness.BEST_EFFORT)
        result = self.execute(controllers, request, time_ns)
        if fallbacks or not result.ok:
            self._events.add(time_ns, 'warning', 'state', f'fallback: {result.message}')

    def _settle_chains(self, controllers: Sequence[Controller[Any]], time_ns: int) -> list[str]:
        """
        Tell controllers whether their references are written; active ones begin anew for it.

        :param controllers: those that are or will be active.
        :returns: failures, in words.
        """
        failures = []
        for controller in in_order(controllers)[::-1]:
            chained = bool(preceding(controller, controllers))
            if chained == controller.chained:
                continue
            if not controller.active:
                controller.chained = chained
                continue
            self._deactivate(controller, time_ns)
            controller.chained = chained
            failures.append(self._activate(controller, time_ns))
        return [text for text in failures if text]

    def _start(self, controller: Controller[Any], controllers: Controllers, time_ns: int) -> str:
        """Activate a controller unless one that follows it has failed to start."""
        for one in following(controller, controllers.values()):
            if not one.active:
                return f"'{controller.name}' stays inactive without '{one.name}'"
        return self._activate(controller, time_ns)

    def _activate(self, controller: Controller[Any], time_ns: int) -> str:
        try:
            controller.activate(time_ns)
        except Exception as error:  # noqa: BLE001 - the others of the request shall go on
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
        return claimed_joints(controllers, self._hardware.index)

    def _refresh(self, controllers: Controllers, time_ns: int) -> None:
        rate = self._parameters.update_rate
        active = []
        for controller in in_order([one for one in controllers.values() if one.active]):
            divisor = max(1, round(rate / controller.update_rate))
            if divisor * controller.update_rate != rate:
                text = (
                    f"'{controller.name}' runs at {rate / divisor:g} Hz instead of "
                    f'{controller.update_rate} Hz: its update_rate has to divide the '
                    f"manager's {rate} Hz"
                )
                self._events.add(time_ns, 'warning', 'warning', text)
            active.append((controller, divisor))
        self.active = tuple(active)
        self.generation += 1

    def _strict(self, strictness: int) -> bool:
        if strictness == 0:
            return self._parameters.defaults.switch_controller.strictness == 'strict'
        return strictness == Strictness.STRICT
