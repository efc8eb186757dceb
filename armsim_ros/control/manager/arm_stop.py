# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Keeps the controllers of an arm from moving it while its drives or its safety do not allow that.

At the begin of a stop all goals end and the joints brake; until its end the controllers are not
updated. Then they start anew where the joints are, so that nothing of an old goal is left.
Grippers have drives of their own and go on.
"""

from __future__ import annotations

from typing import Any

from armsim_ros.control.controller import Controller
from armsim_ros.control.hardware_interface import HardwareInterface
from armsim_ros.control.manager.resources import Resources
from armsim_ros.control.manager.switch_execution import SwitchExecution
from armsim_ros.control.safety.arm_state import ArmState
from armsim_ros.control.safety.braking import Braking
from armsim_ros.control.safety.monitor import StopMonitor
from armsim_ros.model.robot_model import RobotModel


class ArmStop:
    """
    Lets a manager's controllers follow the state of the arm.

    :param arm: the state.
    :param resources: lose the joints of the arm during a stop.
    :param switches: knows the active controllers.
    """

    def __init__(
        self,
        arm: ArmState,
        model: RobotModel | None,
        resources: Resources,
        switches: SwitchExecution,
    ) -> None:
        self.arm = arm
        #: What can stop the arm by itself; None where nothing does.
        self.monitor: StopMonitor | None = None
        #: Why controllers of the arm are not updated, '' where they are.
        self.reason = ''
        self._model, self._resources, self._switches = model, resources, switches
        self._hardware: HardwareInterface = resources.hardware
        self._braking: Braking | None = None

    @property
    def busy(self) -> bool:
        """Whether the next update must be made, because something changes."""
        return self.arm.busy or (self._braking is not None and not self._braking.at_rest)

    def watch(self, monitor: StopMonitor) -> None:
        """Have the arm stopped by what a monitor finds."""
        self.monitor = monitor
        self.arm.present_cause = lambda: monitor.load(self.arm.time_ns)

    def check(self, time_ns: int) -> bool:
        """Stop the arm where the monitor finds a cause; return whether it did."""
        arm, monitor = self.arm, self.monitor
        if monitor is None or not arm.moves:
            return False
        cause = monitor.check(time_ns)
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

    def holds(self, controller: Controller[Any]) -> bool:
        """Return whether a controller is not updated now."""
        return bool(self.reason) and controller.moves_arm

    def write(self, period: float) -> None:
        """Command the joints of the arm, in place of its controllers."""
        if self._braking is not None:
            self._braking.write(period)

    def restart(self, time_ns: int) -> None:
        """Be as at the start: the plant is put elsewhere."""
        self.arm.reset()
        self._braking, self._resources.halted = None, frozenset()
        if self.reason:
            self.reason = ''
            self._switches.follow_hardware(
                [controller for controller, _ in self._switches.active], time_ns)

    def _begin(self, reason: str, time_ns: int) -> None:
        self.reason = reason
        active = [controller for controller, _ in self._switches.active]
        hardware = self._hardware
        taken = {name.rpartition('/')[0] for controller in active if not controller.moves_arm
                 for name in controller.required_command_interfaces}
        joints = [name for name in hardware.joint_names
                  if hardware.command_interfaces.get(name) and name not in taken]
        braking = Braking(hardware, self._model, joints)
        cause = self.arm.cause
        measured = cause is not None and cause.kind == 'collision'
        velocity = braking.measure(measured=measured)
        for controller in active:
            if controller.moves_arm:
                controller.interrupt(time_ns, reason)
        self._resources.halted = braking.joints
        self._switches.follow_hardware(active, time_ns)
        braking.begin(velocity, measured=measured)
        self._braking = braking

    def _end(self, time_ns: int) -> None:
        self._braking, self._resources.halted = None, frozenset()
        active = [controller for controller, _ in self._switches.active]
        self._switches.follow_hardware(active, time_ns)
        self._switches.start_anew(
            [controller for controller in active if controller.moves_arm][::-1], time_ns)
        self.reason = ''
