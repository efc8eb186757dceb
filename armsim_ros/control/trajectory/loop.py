# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
An update of a trajectory controller: read, take requests up, check, sample, write.

This is the hot path; it allocates next to nothing and logs nothing while all goes well.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.config.controllers.joint_trajectory_controller import (
    JointTrajectoryControllerParameters,
)
from armsim_ros.control.command_writer import CommandTargets, CommandWriter, compact
from armsim_ros.control.controller import ControllerContext
from armsim_ros.control.hardware_interface import HardwareInterface, JointProperties
from armsim_ros.control.mailbox import EventQueue, GoalStatus, Mailbox
from armsim_ros.control.trajectory.controller_state import StateRecord, StateRing
from armsim_ros.control.trajectory.execution import Phase, TrajectoryExecution
from armsim_ros.control.trajectory.goal import (
    CancelRequest,
    Request,
    StartRequest,
    superseded,
    TrajectoryErrorCode,
    TrajectoryGoal,
    TrajectoryResult,
)
from armsim_ros.control.trajectory.waypoints import wrap_in_place
from armsim_ros.errors import ControllerError, nearest


def check_configuration(
    parameters: JointTrajectoryControllerParameters, hardware: HardwareInterface
) -> None:
    """
    Refuse parameters that do not fit together or to the hardware.

    :raises ControllerError: the first error.
    """
    for joint in parameters.joints:
        if joint not in hardware.index:
            hint = nearest(joint, hardware.joint_names)
            raise ControllerError(
                f"joint '{joint}' is not a joint of the hardware "
                f"({', '.join(hardware.joint_names)})"
                f'{"; " if hint else ""}{hint}')
    _check_command_joints(parameters, hardware)
    commands = parameters.command_interfaces
    if (commands == ('velocity',) or 'effort' in commands) and (
        'velocity' not in parameters.state_interfaces
    ):
        raise ControllerError(
            f'command_interfaces {", ".join(commands)} need the state_interfaces position and '
            f'velocity, not only {", ".join(parameters.state_interfaces)}')


def _check_command_joints(
    parameters: JointTrajectoryControllerParameters, hardware: HardwareInterface
) -> None:
    joints, commanded = parameters.joints, parameters.commanded
    allowed = (
        f"allowed: some of joints ({', '.join(joints)}), or in place of each of them another "
        "joint of the hardware or 'controller/joint' of a following controller")
    following = sum('/' in name for name in commanded)
    for name in commanded:
        if len(commanded) < len(joints) and name not in joints:
            raise ControllerError(f"command_joints: '{name}' is not among joints; {allowed}")
        if '/' not in name and (following or name not in hardware.index):
            raise ControllerError(f"command_joints: '{name}' is not a joint to command; {allowed}")


def warn_of_configuration(
    parameters: JointTrajectoryControllerParameters, events: EventQueue, time_ns: int
) -> None:
    """Report what a user of these parameters may not expect."""
    if not any(block.goal > 0.0 for block in parameters.constraints.joints.values()):
        text = (
            'goals end with their trajectory; set constraints.<joint>.goal to check the final '
            'positions')
        events.add(time_ns, 'info', 'warning', text)
    if parameters.initial_pace != parameters.speed_scaling.initial_scaling_factor:
        events.warn(time_ns, 'speed_scaling.initial_scaling_factor has no effect: it needs '
                    '[position] alone')
    if parameters.open_loop_control:
        events.warn(
            time_ns, 'open_loop_control is deprecated, use interpolate_from_desired_state')


def stop_brakes(
    parameters: JointTrajectoryControllerParameters, properties: JointProperties,
    events: EventQueue, time_ns: int
) -> Vector | None:
    """
    Return the (n,) decelerations of a stop, or None where it is not to be done that way.

    Where ``decelerate_on_cancel`` is set but something for it is missing, a warning names it.
    """
    if not parameters.constraints.decelerate_on_cancel:
        return None
    brakes = np.array(
        [parameters.constraints.joints[j].max_deceleration_on_cancel for j in parameters.joints])
    lacking = ''
    if 'velocity' not in parameters.state_interfaces:
        lacking = 'there is no velocity state interface'
    for joint, brake, limit in zip(parameters.joints, brakes, properties.velocity, strict=True):
        if not brake > 0.0:
            lacking = f'constraints.{joint}.max_deceleration_on_cancel is not above 0'
        elif not 0.0 < limit < np.inf:
            lacking = f"the URDF gives joint '{joint}' no velocity limit"
    if lacking:
        events.warn(
            time_ns, f'decelerate_on_cancel is not possible, a cancel stops at once: {lacking}')
        return None
    return brakes


def command_timeout(
    parameters: JointTrajectoryControllerParameters, events: EventQueue, time_ns: int
) -> float:
    """Return cmd_timeout [s]; 0, with a warning, where goal_time is not below it."""
    timeout, goal_time = parameters.cmd_timeout, parameters.constraints.goal_time
    if 0.0 < timeout <= goal_time:
        events.warn(
            time_ns, f'cmd_timeout {timeout:g} s is switched off: it has to be above '
            f'constraints.goal_time {goal_time:g} s')
        return 0.0
    return timeout


REQUESTS_PER_UPDATE = 64
"""More have to wait for the next update, so that a burst does not delay the present update."""


class TrajectoryLoop:
    """
    The part of a trajectory controller that the control loop's thread runs.

    :param current: gives the controller's parameters; the next update works with those that it
        gives then.
    :param context: hardware with states to read and commands to write.
    """

    def __init__(
        self, current: Callable[[], JointTrajectoryControllerParameters],
        context: ControllerContext, properties: JointProperties, events: EventQueue, time_ns: int
    ) -> None:
        parameters, hardware = current(), context.hardware
        states, commands = parameters.state_interfaces, parameters.command_interfaces
        joints = len(parameters.joints)
        width = joints * (4 if 'effort' in commands else 3)
        velocity = 'velocity' in states and ('velocity' in commands or 'effort' in commands)
        acceleration = 'acceleration' in states and 'acceleration' in commands
        self._current, self._parameters = current, parameters
        self.ring = StateRing(joints, width, 3 if acceleration else 1 + velocity)
        self.writer = CommandWriter(parameters, hardware)
        self.execution = TrajectoryExecution(
            parameters, width, (True, velocity, acceleration),
            stop_brakes(parameters, properties, events, time_ns), events)
        self._ahead = self.execution.ahead.reshape(-1, joints)
        index = compact([hardware.index[name] for name in parameters.joints])
        self._sources = [
            (row, hardware.state.of(kind), index)
            for row, kind in enumerate(('position', 'velocity', 'acceleration'))
            if kind in states]
        self._index, self._position = index, hardware.state.position
        self._plan = hardware.plan
        owner, _, kind = parameters.speed_scaling.command_interface.rpartition('/')
        self._pace = CommandTargets([(owner, kind)], hardware) if kind else None
        self._continuous = properties.continuous
        self._wraps = len(properties.continuous) > 0
        self._events = events
        self._hardware = hardware
        self.inbox: Mailbox[Request] = Mailbox(context.wake)
        #: The requested pace, until an update takes it over.
        self.wanted_scaling: float | None = None

    def activate(self, time_ns: int) -> None:
        """Hold where the last command is, or where the joints are."""
        self.abort_pending('the controller was not active')
        self._adopt_changes()
        self.execution.cmd_timeout = command_timeout(self._parameters, self._events, time_ns)
        self.writer.reset()
        record = self.ring.open()
        self._read(record)
        hold = record.feedback[0].copy()
        if self._parameters.set_last_command_interface_value_as_state_on_activation:
            last = self.writer.last_positions()
            known = np.isfinite(last)
            hold[known] = last[known]
        self.execution.hold(hold, time_ns)
        record.reference[:] = self.execution.ahead
        self._compare(record)
        self._close(record, time_ns)

    def deactivate(self, message: str) -> None:
        """
        End all goals and let go of the joints.

        :param message: why, for clients that wait for the goals.
        """
        self.execution.end_goals(GoalStatus.ABORTED, message, TrajectoryErrorCode.INVALID_GOAL)
        self.abort_pending(message)
        self.writer.release()

    def update(self, time_ns: int, period: float) -> None:
        """Run an update, see :meth:`Controller.update`."""
        execution = self.execution
        self._adopt_changes()
        record = self._begin(time_ns)
        execution.check(record, time_ns)
        self._note(record, time_ns)
        execution.advance(period)
        self.writer.write(self._ahead, record.error, record.output, period)
        if self._pace is not None:
            self._pace.write(np.array([execution.scaling]))
        self.ring.close(record)

    def next_update(self, time_ns: int) -> int:
        """Return from when on an update matters [ns], see :meth:`Controller.next_update`."""
        if self.writer.closes_loop or self._has_news():
            return time_ns
        return self.execution.next_update(time_ns)

    def plan(self, updates: int, period: float) -> int:
        """Plan updates, see :meth:`Controller.plan`."""
        weights = self.execution.path_check.weights
        if not self.writer.plans or weights is None or self._has_news():
            return 0
        coming = self.execution.coming(period, updates + 1)
        if len(coming) < 2:
            return 0
        coming = coming.reshape(len(coming), -1, self._ahead.shape[1])
        distance = (coming[0, 0] - self._position[self._index]) * weights
        if not float(distance.dot(distance)) < 1.0:
            return 0
        planned = self.writer.plan(coming)
        self._plan.expected[:planned, self._index] = coming[:planned, 0]
        self._plan.weights[self._index] = weights
        return planned

    def pass_updates(self, updates: int, period: float) -> None:
        """Be so many updates further along the trajectory, or after its end."""
        execution = self.execution
        if execution.motion.over(execution.time):
            execution.pass_time(updates * period)
        else:
            execution.go_on(updates)
            self.writer.write_planned(self._ahead)

    def process_requests(self, time_ns: int) -> None:
        """Take requests up while time is paused."""
        self._adopt_changes()
        if self.inbox:
            self._close(self._begin(time_ns), time_ns)

    def abort_pending(self, message: str) -> None:
        """End the goals that were not taken up yet; any thread."""
        for request in self.inbox.take_all():
            goal = getattr(request, 'goal', None)
            if isinstance(goal, TrajectoryGoal) and not isinstance(request, CancelRequest):
                goal.finish(
                    GoalStatus.ABORTED,
                    TrajectoryResult(TrajectoryErrorCode.INVALID_GOAL, message))

    def _begin(self, time_ns: int) -> StateRecord:
        execution = self.execution
        record = self.ring.open()
        record.reference[:] = execution.ahead
        self._read(record)
        self._compare(record)
        if self.inbox or execution.scheduled is not None:
            self._take_requests(record, time_ns)
            execution.start_scheduled(record, time_ns)
            record.reference[:] = execution.ahead
            self._compare(record)
        return record

    def _has_news(self) -> bool:
        """Whether the next update takes up a request, parameters or another pace."""
        return (bool(self.inbox) or self.wanted_scaling is not None or self._pace_changes()
                or self._current() is not self._parameters)

    def _adopt_changes(self) -> None:
        """Work with the parameters and the pace that are requested now."""
        parameters = self._current()
        if parameters is not self._parameters:
            self.writer.set_gains(self._parameters.gains, parameters.gains)
            self._parameters = self.execution.parameters = parameters
        factor = self.wanted_scaling
        if factor is not None:
            self.wanted_scaling = None
            self.execution.scaling = factor
        if self._pace_changes():
            self.execution.scaling = self._hardware.given_states[parameters.speed_source]

    def _pace_changes(self) -> bool:
        """Whether the robot goes at another pace than at the last update."""
        source = self._parameters.speed_source
        factor = self._hardware.given_states.get(source, -1.0) if source else -1.0
        return factor >= 0.0 and factor != self.execution.scaling

    def _take_requests(self, record: StateRecord, time_ns: int) -> None:
        execution = self.execution
        requests = self.inbox.take(REQUESTS_PER_UPDATE)
        passed = superseded(requests, time_ns)
        for i, request in enumerate(requests):
            if i in passed:
                execution.pass_over(passed[i])
            elif isinstance(request, StartRequest):
                execution.take(request, record, time_ns)
            elif isinstance(request, CancelRequest):
                goal = request.goal or execution.active_goal
                if goal is not None:
                    execution.cancel(goal, record, time_ns)
            else:
                execution.stop_on_demand(request.goal, record, time_ns)
            record.reference[:] = execution.ahead

    def _read(self, record: StateRecord) -> None:
        feedback = record.feedback
        for row, values, index in self._sources:
            feedback[row] = values[index]

    def _compare(self, record: StateRecord) -> None:
        reference, feedback, error = record.compared
        np.subtract(reference, feedback, out=error)
        if self._wraps:
            wrap_in_place(error[0], self._continuous)

    def _note(self, record: StateRecord, time_ns: int) -> None:
        execution = self.execution
        record.time_ns = time_ns
        record.scaling = execution.scaling
        record.goal = execution.active_goal
        record.motion = execution.motion if execution.phase is Phase.RUNNING else None
        record.desired_time = execution.time
        record.actual_time = (time_ns - execution.begin_ns) * 1e-9

    def _close(self, record: StateRecord, time_ns: int) -> None:
        self._note(record, time_ns)
        self.ring.close(record)
