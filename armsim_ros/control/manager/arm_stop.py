# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Keeps the controllers of an arm from moving it while its drives or its safety do not allow that.

At the begin of a stop all goals end and the joints brake; until its end the controllers are not
updated. Then they start anew where the joints are, so that nothing of an old goal is left.
Where the vendor's program has to run for it, they are inactive meanwhile. Grippers have drives of
their own and go on.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from armsim_ros.control.controller import Controller
from armsim_ros.control.hardware_interface import HardwareInterface
from armsim_ros.control.manager.resources import Resources
from armsim_ros.control.manager.switch_execution import SwitchExecution, SwitchRequest
from armsim_ros.control.manager.switching import Strictness
from armsim_ros.control.safety.arm_state import ArmState, Program
from armsim_ros.control.safety.braking import Braking
from armsim_ros.control.safety.monitor import StopMonitor
from armsim_ros.model.robot_model import RobotModel


class ArmStop:
    """
    Lets a manager's controllers follow the state of the arm.

    :param arm: the state.
    :param resources: lose the joints of the arm during a stop.
    :param switches: knows the active controllers.
    :param request_switch: takes a switch that is carried out after ``follow``.
    """

    def __init__(
        self,
        arm: ArmState,
        model: RobotModel | None,
        resources: Resources,
        switches: SwitchExecution,
        request_switch: Callable[[SwitchRequest], object],
    ) -> None:
        self.arm = arm
        #: What can stop the arm by itself; None where nothing does.
        self.monitor: StopMonitor | None = None
        #: Why controllers of the arm are not updated, '' where they are.
        self.reason = ''
        self._model, self._resources, self._switches = model, resources, switches
        self._hardware: HardwareInterface = resources.hardware
        self._braking: Braking | None = None
        self._request_switch = request_switch
        #: Controllers that are active again once the program runs.
        self._set_aside: list[str] = []
        #: Whether controllers that become active before the program runs are set aside.
        self._before_program = arm.program is Program.STOPPED
        self._written = -1.0
        self._generation = -1
        self._paces: tuple[str, ...] = ()
        if arm.vendor.pace:
            states = self._hardware.other_states
            self._paces = tuple(name for name in states if name.endswith(arm.vendor.pace)) or (
                arm.vendor.pace,)
            self._write_pace()

    @property
    def due(self) -> bool:
        """Whether the next update has to follow the arm or to check it."""
        return self.arm.busy or self.monitor is not None or self._before_program

    @property
    def busy(self) -> bool:
        """Whether the next update must be made, because something changes."""
        return self.arm.busy or (self._braking is not None and (
            self.arm.freedrive or not self._braking.at_rest))

    def watch(self, monitor: StopMonitor) -> None:
        """Have the arm stopped by what a monitor finds."""
        self.monitor = monitor
        self.arm.present_cause = monitor.load

    def check(self, time_ns: int) -> bool:
        """Stop the arm where the monitor finds a cause; return whether it did."""
        arm, monitor = self.arm, self.monitor
        if monitor is None or not arm.moves:
            return False
        cause = monitor.check(time_ns, yielding=arm.freedrive)
        if cause is None:
            return False
        arm.time_ns = time_ns
        arm.protective_stop(cause)
        return True

    def follow(self, time_ns: int) -> None:
        """Be where the state of the arm is; at the begin of an update."""
        arm = self.arm
        arm.update(time_ns)
        self.check(time_ns)
        self._write_pace()
        if self._before_program and self.reason and self._generation != self._switches.generation:
            self._generation = self._switches.generation
            self._set_controllers_aside()
        if not arm.changed:
            return
        arm.changed = False
        reason = arm.obstacle
        if reason and not self.reason:
            self._begin(reason, time_ns)
        elif self.reason and not reason:
            self._end(time_ns)
        elif reason:
            self.reason = reason
            self._set_controllers_aside()
            if self._braking is not None and not arm.moves:
                self._braking.halt()

    def holds(self, controller: Controller[Any]) -> bool:
        """Return whether a controller is not updated now."""
        return bool(self.reason) and controller.moves_arm

    def write(self, period: float) -> None:
        """Command the joints of the arm, in place of its controllers."""
        if self._braking is not None:
            self._braking.write(period, yielding=self.arm.freedrive)

    @property
    def arm_joints(self) -> tuple[str, ...]:
        """The joints that stop with the arm; in the order of the model."""
        taken = {name.rpartition('/')[0] for controller, _ in self._switches.active
                 if not controller.moves_arm for name in controller.required_command_interfaces}
        for device, _ in self._switches.devices:
            if not device.moves_arm:
                taken.update(device.joints)
        return tuple(name for name in self._hardware.joint_names
                     if self._hardware.command_interfaces.get(name) and name not in taken)

    @property
    def at_rest(self) -> bool:
        """Whether a stop, or a motion by ``move``, has come to its end."""
        return self._braking is None or self._braking.at_rest

    def move(self, targets: Sequence[float] | None, speed: float, acceleration: float,
             duration: float = 0.0) -> None:
        """
        Move the stopped arm without its controllers; nothing happens while it is not stopped.

        :param targets: (n,) of ``arm_joints``; None stays where the arm is [rad or m].
        :param speed: greatest [rad/s or m/s].
        :param acceleration: greatest [rad/s^2 or m/s^2].
        :param duration: the motion takes at least so long [s].
        """
        if self._braking is not None:
            self._braking.move(targets, speed, acceleration, duration)

    def restart(self, time_ns: int) -> None:
        """Be as at the start: the plant is put elsewhere."""
        self.arm.reset()
        self._write_pace()
        self._braking, self._resources.halted = None, frozenset()
        if self.reason:
            self.reason = ''
            self._switches.follow_hardware(
                [controller for controller, _ in self._switches.active], time_ns)
            self._bring_controllers_back()
        self._before_program = self.arm.program is Program.STOPPED

    def _begin(self, reason: str, time_ns: int) -> None:
        self.reason = reason
        active = [controller for controller, _ in self._switches.active]
        braking = Braking(self._hardware, self._model, self.arm_joints)
        cause = self.arm.cause
        measured = cause is not None and cause.kind == 'collision'
        velocity = braking.measure(measured=measured)
        for controller in (*active, *(device for device, _ in self._switches.devices)):
            if controller.moves_arm:
                controller.interrupt(time_ns, reason)
        self._resources.halted = braking.joints
        self._switches.follow_hardware(active, time_ns)
        braking.begin(velocity, measured=measured)
        self._braking = braking
        self._set_controllers_aside()

    def _end(self, time_ns: int) -> None:
        self._braking, self._resources.halted = None, frozenset()
        active = [controller for controller, _ in self._switches.active]
        self._switches.follow_hardware(active, time_ns)
        self._switches.start_anew(
            [controller for controller in active if controller.moves_arm][::-1], time_ns)
        self.reason = ''
        self._bring_controllers_back()

    def _set_controllers_aside(self) -> None:
        """Deactivate the controllers of the arm where its program has stopped."""
        if self.arm.program is not Program.STOPPED:
            return
        names = [controller.name for controller, _ in self._switches.active
                 if controller.moves_arm]
        if names:
            self._set_aside += names
            self._request_switch(SwitchRequest((), names, Strictness.BEST_EFFORT))

    def _bring_controllers_back(self) -> None:
        names, self._set_aside, self._before_program = self._set_aside, [], False
        if names:
            self._request_switch(SwitchRequest(names, (), Strictness.STRICT))

    def _write_pace(self) -> None:
        if not self._paces or self._written == self.arm.pace:
            return
        self._written = self.arm.pace
        for name in self._paces:
            self._hardware.given_states[name] = self.arm.pace
