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
from collections.abc import Sequence
from concurrent.futures import Future
import threading
from typing import Any

from armsim_ros.config.controller_manager import ControllerManagerParameters
from armsim_ros.control.command_limits import CommandLimits
from armsim_ros.control.controller import Controller, ControllerContext, LifecycleState
from armsim_ros.control.controller_factory import (
    CONTROLLER_TYPES,
    create_controller,
    LoadableController,
)
from armsim_ros.control.events import ControllerEvent, EventQueue
from armsim_ros.control.hardware_component import HardwareComponent, HardwareComponentInfo
from armsim_ros.control.hardware_interface import HardwareInterface
from armsim_ros.control.manager_info import (
    controller_info,
    ControllerInfo,
    interface_infos,
    InterfaceInfo,
)
from armsim_ros.control.switch_execution import SwitchExecution, SwitchRequest
from armsim_ros.control.switching import demand, loaded, Strictness, SwitchResult
from armsim_ros.errors import ControllerError
from armsim_ros.model.robot_model import RobotModel

__all__ = [
    'ControllerInfo',
    'ControllerManager',
    'HardwareComponentInfo',
    'InterfaceInfo',
    'Strictness',
    'SwitchResult',
]


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
        self.time_ns = 0
        self.events = EventQueue('controller_manager')
        self._context = ControllerContext(hardware, model, parameters.update_rate)
        self._switches = SwitchExecution(hardware, self.component, parameters, self.events)
        self._changes = 0
        self._tick = 0
        self._structure = threading.RLock()
        self._requests: deque[SwitchRequest] = deque()
        limited = parameters.enforce_command_limits
        self._limits = CommandLimits(hardware, model) if limited else None

    @property
    def generation(self) -> int:
        """Count of all changes of a controller's or the hardware's state."""
        return self._changes + self._switches.generation

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
            self._changes += 1
            return controller

    def configure(self, name: str) -> None:
        """
        Make an unconfigured controller inactive; an inactive one is configured anew.

        :raises ControllerError: it is not loaded, is active, or its parameters do not fit.
        """
        with self._structure:
            controller = loaded(self.controllers, name)
            demand(controller, 'configured', LifecycleState.UNCONFIGURED,
                         LifecycleState.INACTIVE)  # fmt: skip
            controller.state = LifecycleState.UNCONFIGURED
            self._changes += 1
            controller.configure()
            controller.state = LifecycleState.INACTIVE

    def cleanup(self, name: str) -> None:
        """Make an inactive controller unconfigured; ControllerError where it is active."""
        with self._structure:
            controller = loaded(self.controllers, name)
            demand(controller, 'cleaned up', LifecycleState.INACTIVE,
                         LifecycleState.UNCONFIGURED)  # fmt: skip
            controller.state = LifecycleState.UNCONFIGURED
            self._changes += 1

    def unload(self, name: str) -> None:
        """Forget a controller; ControllerError where it is active or not loaded."""
        with self._structure:
            controller = loaded(self.controllers, name)
            demand(controller, 'unloaded', LifecycleState.INACTIVE,
                         LifecycleState.UNCONFIGURED)  # fmt: skip
            controller.state = LifecycleState.FINALIZED
            self.controllers = {k: v for k, v in self.controllers.items() if k != name}
            self._changes += 1

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
        request = SwitchRequest(activate, deactivate, strictness)
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
        request = SwitchRequest(activate, deactivate, strictness)
        with self._structure:
            return self._switches.execute(self.controllers, request, self.time_ns)

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
        for controller, divisor in self._switches.active:
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
        for controller, _ in self._switches.active:
            try:
                controller.process_requests(time_ns)
            except Exception as error:  # noqa: BLE001 - one controller must not stop the others
                self._fail(controller, error)

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
            self._changes += 1

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
                    result = self._switches.execute(self.controllers, request, self.time_ns)
                    request.future.set_result(result)
        finally:
            self._structure.release()

    def _fail(self, controller: Controller[Any], error: Exception) -> None:
        with self._structure:
            self._switches.replace_failed(self.controllers, controller, error, self.time_ns)
