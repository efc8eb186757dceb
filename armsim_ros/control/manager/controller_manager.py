# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The controller manager: loads, configures, switches and updates controllers.

Only the control loop's thread calls :meth:`ControllerManager.update`, or
:meth:`ControllerManager.process_requests` while time is paused; in both, switches that other
threads asked for are carried out. :meth:`ControllerManager.switch` is for that thread alone, and
for the time before the loop runs. All else may be called from any thread: loading and configuring
happen there, and the loop never waits for them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
import threading
from typing import Any

import numpy as np

from armsim_ros.config.controllers.controller_manager import ControllerManagerParameters
from armsim_ros.config.simulation import HardwareSettings
from armsim_ros.control.arm_state import ArmState
from armsim_ros.control.controller import Controller, ControllerContext, LifecycleState
from armsim_ros.control.hardware_interface import COMMAND_INTERFACES, HardwareInterface
from armsim_ros.control.mailbox import ControllerEvent, EventQueue, Mailbox
from armsim_ros.control.manager.arm_stop import ArmStop
from armsim_ros.control.manager.controller_factory import (
    CONTROLLER_TYPES,
    create_controller,
    LoadableController,
)
from armsim_ros.control.manager.manager_info import (
    controller_info,
    ControllerInfo,
    in_order,
    InterfaceInfo,
    withdraw,
)
from armsim_ros.control.manager.resources import HardwareComponentInfo, Resources
from armsim_ros.control.manager.switch_execution import (
    SwitchExecution,
    SwitchRequest,
    UpdatesAhead,
)
from armsim_ros.control.manager.switching import (
    fallbacks_of,
    find_controller,
    require_state,
    require_unique_interfaces,
    Strictness,
    SwitchResult,
)
from armsim_ros.errors import ControllerError
from armsim_ros.model.robot_model import RobotModel


def any_arm(events: EventQueue, wake: Callable[[], object]) -> ArmState:
    """Return the state of an arm without a vendor."""
    return ArmState(HardwareSettings(), None, events, wake)


class ControllerManager:
    """
    The controllers of a robot.

    :param hardware: the joints.
    :param parameters: update rate, defaults, fallback controllers.
    :param model: joint types and limits; without it no joint turns without end and none has
        limits.
    :param arm: drives and safety of the arm, by default of an arm without a vendor.
    """

    def __init__(
        self, hardware: HardwareInterface, parameters: ControllerManagerParameters,
        model: RobotModel | None = None,
        arm: Callable[[EventQueue, Callable[[], object]], ArmState] = any_arm
    ) -> None:
        self.parameters, self.hardware = parameters, hardware
        self.controllers: dict[str, Controller[Any]] = {}
        self.refusals: list[str] = []
        """Why controllers that should run from the start do not."""
        self.time_ns = 0
        self.events = EventQueue('controller_manager')
        self.resources = Resources(hardware, model, parameters, self.events)
        self._wake: Callable[[], object] = lambda: None
        self.context = ControllerContext(
            hardware, model, parameters.update_rate, lambda: self._wake(), self._obstacle)
        self._switches = SwitchExecution(self.resources, parameters, self.events)
        self._changes = 0
        self._tick = 0
        self._resumed = False
        self._structure = threading.RLock()
        self._requests: Mailbox[SwitchRequest] = Mailbox(self.context.wake)
        self._failures: dict[str, Exception] = {}
        self.stops = ArmStop(arm(self.events, self.context.wake), model, self.resources,
                             self._switches, self._requests.post, self.events)
        self._ahead = UpdatesAhead((), 0, 0, 0.0)

    @property
    def generation(self) -> int:
        """Count of all changes of a controller's or the hardware's state."""
        return self._changes + self._switches.generation

    def attach(self, device: Controller[Any]) -> None:
        """
        Have a device updated after the controllers; for the control loop's own thread.

        A device commands positions of its joints while no controller claims them. It is not
        loaded, and no list has it.

        :param device: configured.
        """
        self._switches.attach(device, self.time_ns)

    def load(
        self, settings: LoadableController, fallback_controllers: Sequence[str] | None = None
    ) -> Controller[Any]:
        """
        Load a controller; it is unconfigured then.

        :param fallback_controllers: take over when it fails; None takes the parameters' ones.
        :raises ControllerError: the name is taken, the type unknown or a parameter wrong.
        """
        with self._structure:
            if settings.name in self.controllers:
                raise ControllerError(f"a controller '{settings.name}' is loaded already")
            controller = create_controller(
                settings.name, settings.type, settings.parameters, self.context)
            controller.fallback_controllers = fallbacks_of(
                settings.name, self.parameters, fallback_controllers)
            controller.time_ns = self.time_ns
            self.controllers = {**self.controllers, settings.name: controller}
            self._changes += 1
            return controller

    def configure(self, name: str) -> None:
        """
        Make an unconfigured controller inactive; an inactive controller is configured anew.

        :raises ControllerError: it is not loaded, is active, or its parameters do not fit.
        """
        with self._structure:
            controller = find_controller(self.controllers, name)
            require_state(controller, 'configured', LifecycleState.UNCONFIGURED,
                          LifecycleState.INACTIVE)
            controller.state = LifecycleState.UNCONFIGURED
            self._changes += 1
            withdraw(controller, self.hardware)
            controller.take_parameters()
            controller.configure()
            require_unique_interfaces(controller)
            controller.warn_of_rate()
            references = self.hardware.references
            references.update(dict.fromkeys(controller.reference_interfaces, np.nan))
            controller.state = LifecycleState.INACTIVE

    def cleanup(self, name: str) -> None:
        """Make an inactive controller unconfigured; ControllerError where it is active."""
        with self._structure:
            self._take_down(name, 'cleaned up', LifecycleState.UNCONFIGURED)
            self._changes += 1

    def unload(self, name: str) -> None:
        """Forget a controller; ControllerError where it is active or not loaded."""
        with self._structure:
            self._take_down(name, 'unloaded', LifecycleState.FINALIZED)
            self.controllers = {k: v for k, v in self.controllers.items() if k != name}
            self._changes += 1

    def _take_down(self, name: str, deed: str, state: LifecycleState) -> None:
        controller = find_controller(self.controllers, name)
        require_state(controller, deed, LifecycleState.INACTIVE, LifecycleState.UNCONFIGURED)
        controller.state = state
        withdraw(controller, self.hardware)

    def request_switch(
        self, activate: Sequence[str] = (), deactivate: Sequence[str] = (),
        strictness: int = Strictness.STRICT
    ) -> Future[SwitchResult]:
        """
        Ask the control loop for a switch.

        :param strictness: 0 takes the manager's default.
        :returns: done after the loop's next update, or at once while time is paused.
        """
        request = SwitchRequest(tuple(activate), tuple(deactivate), strictness)
        self._requests.post(request)
        return request.future

    def switch(
        self, activate: Sequence[str] = (), deactivate: Sequence[str] = (),
        strictness: int = Strictness.STRICT
    ) -> SwitchResult:
        """
        Stop and start controllers in a single switch; for the control loop's own thread.

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
        self._resumed = False
        stops = self.stops
        if stops.due:
            stops.follow(time_ns)
        if self._requests or self._failures:
            self._serve()
        tick = self._tick
        self._tick = tick + 1
        for controller, divisor in self._switches.active + self._switches.devices:
            if (divisor > 1 and tick % divisor) or controller.name in self._failures:
                continue
            if stops.reason and stops.holds(controller):
                continue
            try:
                controller.update(time_ns, period * divisor)
            except Exception as error:  # noqa: BLE001 - one controller must not stop the others
                self._fail(controller, error)
        if self.resources.limits is not None:
            self.resources.limits.enforce(period)
        if self.resources.holds:
            self.resources.hold_idle_joints()
        if stops.reason:
            stops.write(period)

    def plan(self, updates: int, time_ns: int, period: float, *, moving: bool) -> int:
        """Plan updates of all active controllers, see :meth:`Controllers.plan`."""
        if (self._requests or self._failures or self._resumed or self.resources.limits is not None
                or self.stops.busy or (moving and (self.resources.holds or self.stops.reason))):
            return 0
        self._ahead = UpdatesAhead(self._updated, self._tick, time_ns, period)
        return self._ahead.plan(updates, moving=moving)

    def next_reading(self, update: int, updates: int) -> int:
        """Return when states are read, see :meth:`Controllers.next_reading`."""
        if self.stops.monitor is not None:
            return min(update, updates)
        return self._ahead.next_reading(update, updates)

    def read(self, update: int) -> bool:
        """Have states read at an update of the plan; return whether no controller failed."""
        if self.stops.monitor is not None:
            if self.stops.check(self._ahead.time_ns(update)):
                return False
            if self._ahead.next_reading(update, update + 1) > update:
                return True
        self._ahead.read(update, self._failures)
        return not self._failures

    def pass_updates(self, updates: int, period: float) -> None:
        """Be where so many updates, a period [s] apart, have led that were not made."""
        before = self._tick
        self._tick += updates
        for controller, divisor in self._updated:
            # Its own updates have numbers that are multiples of the divisor.
            due = -(-self._tick // divisor) - -(-before // divisor)
            if due:
                controller.pass_updates(due, period * divisor)

    def wake_with(self, wake: Callable[[], object]) -> None:
        """Have a function called, from any thread, when there is something for the next update."""
        self._wake = wake

    def process_requests(self, time_ns: int) -> None:
        """Carry out switches and take up goals and cancels while time is paused."""
        self.time_ns = time_ns
        if self.stops.busy:
            self.stops.follow(time_ns)
        if self._requests or self._failures:
            self._serve()
        for controller, _ in self._updated:
            self._try(controller, controller.process_requests, time_ns)

    def interrupt(self, time_ns: int, reason: str) -> None:
        """
        End the goals of all active controllers before the plant is put elsewhere.

        :param reason: for clients that wait for a goal.
        """
        for controller, _ in self._switches.active + self._switches.devices:
            controller.interrupt(time_ns, reason)

    def resume(self, time_ns: int) -> None:
        """Have the active controllers take over the plant where it is now."""
        for arrays in (self.hardware.command, self.hardware.feedforward):
            for kind in COMMAND_INTERFACES:
                arrays.of(kind)[:] = np.nan
        self.stops.restart(time_ns)
        self.resources.restart()
        self._resumed = True
        for controller, _ in reversed(self._switches.active + self._switches.devices):
            self._try(controller, controller.activate, time_ns)

    def list_controllers(self) -> list[ControllerInfo]:
        """Return all loaded controllers, those of a chain from its beginning on."""
        controllers = in_order(list(self.controllers.values()))
        return [controller_info(controller, controllers) for controller in controllers]

    def list_hardware_interfaces(self) -> tuple[list[InterfaceInfo], list[InterfaceInfo]]:
        """Return command interfaces and state interfaces, as ``joint/interface``."""
        return self.resources.interfaces(self.controllers.values())

    def list_hardware_components(self) -> list[HardwareComponentInfo]:
        """Return the hardware that the URDF declares, else the robot as the only component."""
        return self.resources.info(self.controllers.values())

    def set_hardware_component_state(self, name: str, state: str) -> None:
        """
        Bring the hardware into a state; controllers go on, and joints that are not active hold.

        :raises ControllerError: an unknown name or state.
        """
        with self._structure:
            self.resources.set_state(name, state)
            self._changes += 1
        self._requests.post(SwitchRequest(hardware_changed=True))

    def list_types(self) -> dict[str, bool]:
        """Return the types that can be loaded, and whether they are chainable."""
        return {name: kind.chainable for name, kind in CONTROLLER_TYPES.items()}

    def poll_events(self) -> list[ControllerEvent]:
        """Return the messages of the manager and its controllers since the last call."""
        events = self.events.drain()
        for controller in (*self.controllers.values(),
                           *(device for device, _ in self._switches.devices)):
            events += controller.poll_events()
        return sorted(events, key=lambda event: event.time_ns) if events else events

    @property
    def arm(self) -> ArmState:
        """Drives and safety of the arm."""
        return self.stops.arm

    @property
    def _updated(self) -> tuple[tuple[Controller[Any], int], ...]:
        """The active controllers that are updated now, with the manager's updates per update."""
        active = self._switches.active + self._switches.devices
        if not self.stops.reason:
            return active
        return tuple(entry for entry in active if not self.stops.holds(entry[0]))

    def _obstacle(self) -> str:
        """Return why the arm takes no commands, '' where it does; any thread."""
        return self.stops.reason or self.stops.arm.obstacle

    def _serve(self) -> None:
        if not self._structure.acquire(blocking=False):
            return
        try:
            failures, self._failures = self._failures, {}
            for name, error in failures.items():
                if (failed := self.controllers.get(name)) is not None:
                    self._switches.replace_failed(self.controllers, failed, error, self.time_ns)
                else:
                    self._switches.detach_failed(name, error, self.time_ns)
            for request in self._requests.take_all():
                if request.future.set_running_or_notify_cancel():
                    result = self._switches.execute(self.controllers, request, self.time_ns)
                    request.future.set_result(result)
        finally:
            self._structure.release()

    def _try(
        self, controller: Controller[Any], call: Callable[[int], object], time_ns: int
    ) -> None:
        """Make a call of a controller that has not failed; it fails with what the call raises."""
        if controller.name not in self._failures:
            try:
                call(time_ns)
            except Exception as error:  # noqa: BLE001 - one controller must not stop the others
                self._fail(controller, error)

    def _fail(self, controller: Controller[Any], error: Exception) -> None:
        """Replace a controller that raised; where others change the controllers, a bit later."""
        self._failures[controller.name] = error
        self._serve()
