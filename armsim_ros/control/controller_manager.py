# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The controller manager: loads, configures, switches and updates controllers.

One thread, the control loop's, calls :meth:`ControllerManager.update`, or
:meth:`ControllerManager.process_requests` while time stands still; in both, switches that other
threads asked for are carried out. :meth:`ControllerManager.switch` is for that thread alone, and
for the time before the loop runs. All else may be called from any thread: loading and configuring
happen there, and the loop never waits for them.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from concurrent.futures import Future
import threading
from typing import Any, Protocol

import numpy as np

from armsim_ros.config.base import Settings
from armsim_ros.config.controller_manager import ControllerManagerParameters
from armsim_ros.control.command_limits import CommandLimits
from armsim_ros.control.controller import Controller, ControllerContext, LifecycleState
from armsim_ros.control.controller_factory import CONTROLLER_TYPES, create_controller
from armsim_ros.control.events import ControllerEvent, EventQueue
from armsim_ros.control.hardware_component import HardwareComponent, HardwareComponentInfo
from armsim_ros.control.hardware_interface import HardwareInterface, POSITION
from armsim_ros.control.manager_info import (
    controller_info,
    ControllerInfo,
    interface_infos,
    InterfaceInfo,
)
from armsim_ros.control.switching import claimed_joints, plan_switch, Strictness, SwitchResult
from armsim_ros.errors import ArmsimError, ControllerError, nearest
from armsim_ros.model.robot_model import RobotModel

__all__ = [
    'ControllerInfo',
    'ControllerManager',
    'HardwareComponentInfo',
    'InterfaceInfo',
    'Strictness',
    'SwitchResult',
]


class LoadableController(Protocol):
    """What the manager has to know of a controller to load it."""

    @property
    def name(self) -> str:
        """Name of the controller."""

    @property
    def type(self) -> str:
        """ROS 2 type of the controller."""

    @property
    def parameters(self) -> Settings | Mapping[str, Any]:
        """Checked parameters, or a mapping to check."""


class _Request:
    """A switch that waits for the control loop."""

    __slots__ = ('activate', 'deactivate', 'future', 'strictness')

    def __init__(self, activate: Sequence[str], deactivate: Sequence[str], strictness: int):
        self.activate = tuple(activate)
        self.deactivate = tuple(deactivate)
        self.strictness = strictness
        self.future: Future[SwitchResult] = Future()


class ControllerManager:
    """
    The controllers of one robot.

    :param hardware: the joints.
    :param parameters: update rate, defaults, fallback controllers.
    :param model: joint types and limits; without it no joint turns without end and none has
        limits.
    """

    def __init__(
        self,
        hardware: HardwareInterface,
        parameters: ControllerManagerParameters,
        model: RobotModel | None = None,
    ) -> None:
        """Start without controllers."""
        self.parameters = parameters
        self.hardware = hardware
        self.component = HardwareComponent(hardware, model)
        self.controllers: dict[str, Controller[Any]] = {}
        self.generation = 0
        self.time_ns = 0
        self.events = EventQueue('controller_manager')
        self._context = ControllerContext(hardware, model, parameters.update_rate)
        self._active: tuple[tuple[Controller[Any], int], ...] = ()
        self._tick = 0
        self._structure = threading.RLock()
        self._requests: deque[_Request] = deque()
        limited = parameters.enforce_command_limits
        self._limits = CommandLimits(hardware, model) if limited else None

    def load(self, settings: LoadableController) -> Controller[Any]:
        """
        Load a controller; it is unconfigured then.

        :raises ControllerError: the name is taken, the type unknown or a parameter wrong.
        """
        with self._structure:
            if settings.name in self.controllers:
                raise ControllerError(f"a controller '{settings.name}' is loaded already")
            controller = create_controller(
                settings.name, settings.type, settings.parameters, self._context
            )
            controller.time_ns = self.time_ns
            self.controllers = {**self.controllers, settings.name: controller}
            self.generation += 1
            return controller

    def configure(self, name: str) -> None:
        """
        Make an unconfigured controller inactive; an inactive one is configured anew.

        :raises ControllerError: it is not loaded, is active, or its parameters do not fit.
        """
        with self._structure:
            controller = self._loaded(name)
            self._demand(controller, 'configured', LifecycleState.UNCONFIGURED,
                         LifecycleState.INACTIVE)  # fmt: skip
            controller.state = LifecycleState.UNCONFIGURED
            self.generation += 1
            controller.configure()
            controller.state = LifecycleState.INACTIVE

    def cleanup(self, name: str) -> None:
        """Make an inactive controller unconfigured; ControllerError where it is active."""
        with self._structure:
            controller = self._loaded(name)
            self._demand(controller, 'cleaned up', LifecycleState.INACTIVE,
                         LifecycleState.UNCONFIGURED)  # fmt: skip
            controller.state = LifecycleState.UNCONFIGURED
            self.generation += 1

    def unload(self, name: str) -> None:
        """Forget a controller; ControllerError where it is active or not loaded."""
        with self._structure:
            controller = self._loaded(name)
            self._demand(controller, 'unloaded', LifecycleState.INACTIVE,
                         LifecycleState.UNCONFIGURED)  # fmt: skip
            controller.state = LifecycleState.FINALIZED
            self.controllers = {k: v for k, v in self.controllers.items() if k != name}
            self.generation += 1

    def request_switch(
        self,
        activate: Sequence[str] = (),
        deactivate: Sequence[str] = (),
        strictness: int = Strictness.STRICT,
    ) -> Future[SwitchResult]:
        """
        Ask the control loop for a switch.

        :param strictness: 0 takes the manager's default.
        :returns: done after the loop's next update, or while time stands still at once.
        """
        request = _Request(activate, deactivate, strictness)
        self._requests.append(request)
        return request.future

    def switch(
        self,
        activate: Sequence[str] = (),
        deactivate: Sequence[str] = (),
        strictness: int = Strictness.STRICT,
    ) -> SwitchResult:
        """
        Stop and start controllers in one go; for the control loop's own thread.

        :param strictness: 0 takes the manager's default.
        """
        with self._structure:
            return self._switch(_Request(activate, deactivate, strictness))

    def update(self, time_ns: int, period: float) -> None:
        """
        Update all active controllers that are due.

        A controller that fails is deactivated, and its fallback controllers take its place.

        :param time_ns: the time of the present states [ns].
        :param period: until the next update [s].
        """
        self.time_ns = time_ns
        if self._requests:
            self._serve()
        tick = self._tick
        self._tick = tick + 1
        for controller, divisor in self._active:
            if divisor > 1 and tick % divisor:
                continue
            try:
                controller.update(time_ns, period * divisor)
            except Exception as error:  # noqa: BLE001 - one controller must not stop the others
                self._fail(controller, error)
        if self._limits is not None:
            self._limits.enforce()

    def process_requests(self, time_ns: int) -> None:
        """Carry out switches and take up goals and cancels while time stands still."""
        self.time_ns = time_ns
        if self._requests:
            self._serve()
        for controller, _ in self._active:
            controller.process_requests(time_ns)

    def list_controllers(self) -> list[ControllerInfo]:
        """Return all loaded controllers in the order of loading."""
        return [controller_info(controller) for controller in self.controllers.values()]

    def list_hardware_interfaces(self) -> tuple[list[InterfaceInfo], list[InterfaceInfo]]:
        """Return command interfaces and state interfaces, as ``joint/interface``."""
        return interface_infos(self.hardware, self.controllers.values(), self.component.active)

    def list_hardware_components(self) -> list[HardwareComponentInfo]:
        """Return the robot as its only hardware component."""
        return [self.component.info()]

    def set_hardware_component_state(self, name: str, state: str) -> None:
        """
        Bring the hardware into a state.

        :param state: unconfigured, inactive, active or finalized.
        :raises ControllerError: an unknown name or state, or active controllers need it.
        """
        with self._structure:
            users = [n for n, c in self.controllers.items()
                     if c.active and c.required_command_interfaces]  # fmt: skip
            self.component.set_state(name, state, users)
            self.generation += 1

    def list_types(self) -> list[str]:
        """Return the types of controllers that can be loaded."""
        return list(CONTROLLER_TYPES)

    def poll_events(self) -> list[ControllerEvent]:
        """Return what the manager and its controllers had to say since the last call."""
        events = self.events.drain()
        for controller in self.controllers.values():
            events += controller.poll_events()
        return sorted(events, key=lambda event: event.time_ns)

    def _serve(self) -> None:
        if not self._structure.acquire(blocking=False):
            return
        try:
            while self._requests:
                request = self._requests.popleft()
                if request.future.set_running_or_notify_cancel():
                    request.future.set_result(self._switch(request))
        finally:
            self._structure.release()

    def _switch(self, request: _Request) -> SwitchResult:
        plan = plan_switch(self.controllers, self.hardware, request.activate, request.deactivate)
        problems = list(plan.problems)
        activate = plan.activate
        if activate and not self.component.active:
            problems.append(f"hardware '{self.component.name}' is {self.component.state.value}")
            activate = ()
        if problems and self._strict(request.strictness):
            return SwitchResult(False, f'nothing was switched: {"; ".join(problems)}')
        asked = bool(request.activate or request.deactivate)
        if not (activate or plan.deactivate):
            text = '; '.join(['nothing to do', *problems])
            return SwitchResult(True, text if asked else 'nothing to do')
        remaining = [c for n, c in self.controllers.items() if c.active
                     and n not in plan.deactivate]  # fmt: skip
        wanted = remaining + [self.controllers[name] for name in activate]
        try:
            self.hardware.perform_command_mode_switch(claimed_joints(wanted))
        except ArmsimError as error:
            return SwitchResult(False, f'nothing was switched: {error}')
        for name in plan.deactivate:
            self._deactivate(self.controllers[name])
        self._forget_positions(wanted)
        failures = [text for name in activate if (text := self._activate(self.controllers[name]))]
        if failures:
            self.hardware.perform_command_mode_switch(
                claimed_joints([c for c in wanted if c.active])
            )
        self._refresh()
        return SwitchResult(not failures, '; '.join(failures + problems) or 'controllers switched')

    def _activate(self, controller: Controller[Any]) -> str:
        try:
            controller.activate(self.time_ns)
        except ControllerError as error:
            text = f"'{controller.name}' could not be activated: {error}"
            self.events.add(self.time_ns, 'error', 'state', text)
            return text
        controller.state = LifecycleState.ACTIVE
        self.events.add(self.time_ns, 'info', 'state', f"'{controller.name}' is active")
        return ''

    def _deactivate(self, controller: Controller[Any]) -> None:
        controller.state = LifecycleState.INACTIVE
        controller.deactivate(self.time_ns)
        self.events.add(self.time_ns, 'info', 'state', f"'{controller.name}' is inactive")

    def _forget_positions(self, controllers: Sequence[Controller[Any]]) -> None:
        """Erase position commands that grow old while another interface moves the joint."""
        for joint, kinds in claimed_joints(controllers).items():
            if POSITION not in kinds:
                self.hardware.command.position[self.hardware.index[joint]] = np.nan

    def _fail(self, controller: Controller[Any], error: Exception) -> None:
        what = f'{error.__class__.__name__}: {error}'
        text = f"'{controller.name}' failed and is deactivated: {what}"
        self.events.add(self.time_ns, 'error', 'failure', text)
        entry = self.parameters.controllers.get(controller.name)
        fallbacks = entry.fallback_controllers if entry is not None else ()
        with self._structure:
            result = self._switch(_Request(fallbacks, (controller.name,), Strictness.BEST_EFFORT))
        if fallbacks or not result.ok:
            self.events.add(self.time_ns, 'warning', 'state', result.message)

    def _refresh(self) -> None:
        rate = self.parameters.update_rate
        active = []
        for controller in self.controllers.values():
            if controller.active:
                divisor = max(1, round(rate / controller.update_rate))
                if divisor * controller.update_rate != rate:
                    text = (
                        f"'{controller.name}' runs at {rate / divisor:g} Hz instead of "
                        f'{controller.update_rate} Hz: its update_rate has to divide the '
                        f"manager's {rate} Hz"
                    )
                    self.events.add(self.time_ns, 'warning', 'warning', text)
                active.append((controller, divisor))
        self._active = tuple(active)
        self.generation += 1

    def _strict(self, strictness: int) -> bool:
        if strictness == 0:
            return self.parameters.defaults.switch_controller.strictness == 'strict'
        return strictness == Strictness.STRICT

    def _loaded(self, name: str) -> Controller[Any]:
        try:
            return self.controllers[name]
        except KeyError:
            known = tuple(self.controllers)
            hint = nearest(name, known) or f'loaded: {", ".join(known) or "none"}'
            raise ControllerError(f"no controller '{name}' is loaded; {hint}") from None

    @staticmethod
    def _demand(controller: Controller[Any], verb: str, *states: LifecycleState) -> None:
        if controller.state not in states:
            raise ControllerError(
                f"'{controller.name}' is {controller.state.value} and cannot be {verb}; allowed: "
                f'{" or ".join(state.value for state in states)}'
            )
