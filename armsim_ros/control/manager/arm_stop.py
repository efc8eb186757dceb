# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Brings an arm to rest, and keeps its controllers off it until drives and safety allow motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import Any

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.control.arm_state import ArmState, Program
from armsim_ros.control.controller import Controller
from armsim_ros.control.hardware_interface import (
    ACCELERATION,
    COMMAND_INTERFACES,
    HardwareInterface,
)
from armsim_ros.control.mailbox import EventQueue
from armsim_ros.control.manager.manager_info import dependents
from armsim_ros.control.manager.resources import Resources
from armsim_ros.control.manager.switch_execution import SwitchExecution, SwitchRequest
from armsim_ros.control.manager.switching import clash, Strictness, SwitchResult
from armsim_ros.control.stop_monitor import StopMonitor
from armsim_ros.model.robot_model import RobotModel

#: Deceleration of joints without a limit [rad/s^2 or m/s^2].
DECELERATION = 10.0
#: All joints rest at the latest after this time [s].
LONGEST_STOP = 0.4
#: Where a command is farther from its joint, the motion goes on from the joint [rad or m].
NEAR = 0.02
#: Share of its speed that a joint keeps from one control period to the next while it yields.
YIELD = 0.98


class Braking:
    """
    A stop of some joints.

    :param joints: those that are stopped.
    :param model: gives limits of acceleration.
    """

    def __init__(
        self, hardware: HardwareInterface, model: RobotModel | None, joints: Sequence[str]
    ) -> None:
        self.joints = frozenset(joints)
        self._hardware = hardware
        self._places = np.array([hardware.index[name] for name in joints], dtype=np.intp)
        known = model.hardware_joints if model is not None else {}
        limits = [abs(known[name].bounds[ACCELERATION][0]) if name in known
                  and ACCELERATION in known[name].bounds else np.inf for name in joints]
        self._limits = np.array([limit if 0.0 < limit < np.inf else DECELERATION
                                 for limit in limits])
        self._start = self._velocity = np.zeros(len(joints))
        self._duration = self._time = 0.0
        self._way: Vector | None = None

    def measure(self, *, measured: bool) -> Vector:
        """
        Return how fast the joints are to be when they begin to slow down (n,).

        :param measured: whether the joints' own motion counts, not that of their commands.
        """
        hardware, places = self._hardware, self._places
        velocity = hardware.state.velocity[places].copy()
        given = hardware.feedforward.velocity[places]
        if not measured:
            follows = np.isfinite(given) & self._near()
            velocity[follows] = given[follows]
        return velocity

    def begin(self, velocity: Vector, *, measured: bool) -> None:
        """
        Begin to slow down from what the drives follow now.

        :param velocity: (n,) at the begin [rad/s or m/s].
        :param measured: as for ``measure``.
        """
        hardware, places = self._hardware, self._places
        self._start = hardware.state.position[places].copy()
        if not measured:
            near = self._near()
            self._start[near] = hardware.command.position[places][near]
        self._velocity, self._way = velocity, None
        longest = float(np.max(np.abs(velocity) / self._limits, initial=0.0))
        self._duration, self._time = min(longest, LONGEST_STOP), 0.0

    def halt(self) -> None:
        """Slow down whatever moves the stopped arm."""
        yields = self._way is None and self.at_rest
        self.begin(self.measure(measured=yields), measured=yields)

    def move(self, targets: Sequence[float] | None, speed: float, acceleration: float,
             duration: float) -> None:
        """Move on from where the joints are commanded to be, see ``ArmStop.move``."""
        here = self._hardware.command.position[self._places].copy()
        way = np.zeros_like(here) if targets is None else np.array(targets) - here
        farthest = float(np.max(np.abs(way), initial=0.0))
        if farthest > 0.0 and not duration:
            # A quintic from rest to rest has 15/8 of its mean speed and 10/sqrt(3) of
            # distance / time^2 as greatest values.
            duration = max(1.875 * farthest / speed, (5.7735 * farthest / acceleration)**0.5)
        self._start, self._way = here, way if farthest > 0.0 else None
        self._velocity = np.zeros_like(here)
        self._duration, self._time = duration if farthest > 0.0 else 0.0, 0.0

    def write(self, period: float, *, yielding: bool = False) -> None:
        """
        Command where the joints are to be a period [s] ahead; nothing else reaches them.

        :param yielding: whether the joints go where forces from outside move them.
        """
        self._time += period
        hardware, places, whole = self._hardware, self._places, self._duration
        position, velocity = self._start, np.zeros_like(self._velocity)
        acceleration = velocity
        if self._way is not None:
            u = min(self._time / whole, 1.0)
            position = position + self._way * (u**3 * (10.0 - 15.0 * u + 6.0 * u**2))
            velocity = self._way * (30.0 * u**2 * (1.0 - u)**2 / whole)
            acceleration = self._way * (60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / whole**2)
        elif whole > 0.0:
            time = min(self._time, whole)
            position = position + self._velocity * (time - time**2 / (2.0 * whole))
            velocity = self._velocity * (1.0 - time / whole)
            if time < whole:
                acceleration = -self._velocity / whole
        elif yielding:
            velocity = YIELD * hardware.state.velocity[places]
            position = self._start = hardware.state.position[places] + period * velocity
        for kind in COMMAND_INTERFACES:
            hardware.command.of(kind)[places] = np.nan
            hardware.feedforward.of(kind)[places] = np.nan
        hardware.command.position[places] = position
        hardware.feedforward.velocity[places] = velocity
        hardware.feedforward.acceleration[places] = acceleration

    @property
    def at_rest(self) -> bool:
        """Whether the commands stay as they are."""
        return self._time >= self._duration

    def _near(self) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        hardware, places = self._hardware, self._places
        distance = np.abs(hardware.command.position[places] - hardware.state.position[places])
        near: np.ndarray[tuple[int], np.dtype[np.bool_]] = distance < NEAR  # NaN is not near
        return near


class ArmStop:
    """
    Lets a manager's controllers follow the state of the arm.

    :param arm: the state.
    :param resources: lose the joints of the arm during a stop.
    :param switches: knows the active controllers.
    :param request_switch: takes a switch that is carried out after ``follow``.
    :param events: get an error where controllers stay inactive although the program runs.
    """

    def __init__(
        self, arm: ArmState, model: RobotModel | None, resources: Resources,
        switches: SwitchExecution, request_switch: Callable[[SwitchRequest], object],
        events: EventQueue
    ) -> None:
        self.arm = arm
        #: What can stop the arm by itself; None where nothing does.
        self.monitor: StopMonitor | None = None
        #: Why controllers of the arm are not updated, '' where they are.
        self.reason = ''
        self._model, self._resources, self._switches = model, resources, switches
        self._hardware: HardwareInterface = resources.hardware
        self._braking: Braking | None = None
        self._request_switch, self._events = request_switch, events
        #: Controllers that are active again once the program runs, by name.
        self._set_aside: dict[str, Controller[Any]] = {}
        #: Whether those have been set aside that were active when the program stopped.
        self._program_stopped = False
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
            if self._braking is not None and not arm.moves:
                self._braking.halt()
        if not self._program_stopped:
            self._set_controllers_aside()
        self._program_stopped = arm.program is Program.STOPPED

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
        taken = {name for controller, _ in self._switches.active
                 if not controller.moves_arm for name in controller.moved_joints}
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
        if self.arm.program is Program.STOPPED:
            self._request_switch(SwitchRequest(
                (), self._controllers_of_the_program, Strictness.BEST_EFFORT))

    def _controllers_of_the_program(self) -> tuple[str, ...]:
        """
        Return which controllers are set aside.

        What cannot be active together with those set aside before is left as it is.
        """
        active = [controller for controller, _ in self._switches.active]
        before = self._set_aside.values()
        moving = [controller for controller in active
                  if (controller.moves_arm or controller.frees_arm)
                  and not any(clash(controller, other) for other in before
                              if other.name != controller.name)]
        setting = {each.name: each for each in (*moving, *dependents(moving, active))}
        self._set_aside.update(setting)
        return tuple(setting)

    def _bring_controllers_back(self) -> None:
        self._before_program = self._program_stopped = False
        request = SwitchRequest(self._controllers_to_return, (), Strictness.STRICT)
        request.future.add_done_callback(self._report)
        self._request_switch(request)

    def _controllers_to_return(self) -> tuple[str, ...]:
        """Return which controllers were set aside and are not active; they are forgotten."""
        active = {controller.name for controller, _ in self._switches.active}
        names = tuple(name for name in self._set_aside if name not in active)
        self._set_aside = {}
        return names

    def _report(self, switched: Future[SwitchResult]) -> None:
        result = switched.result()
        if not result.ok:
            self._events.add(self.arm.time_ns, 'error', 'state',
                             f'the program runs without its controllers: {result.message}')

    def _write_pace(self) -> None:
        if not self._paces or self._written == self.arm.pace:
            return
        self._written = self.arm.pace
        for name in self._paces:
            self._hardware.given_states[name] = self.arm.pace
