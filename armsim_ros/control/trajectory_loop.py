# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
One update of a trajectory controller: read, take requests up, judge, sample, write.

This is the hot path; it allocates next to nothing and logs nothing while all goes well.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from armsim_ros.config.joint_trajectory_controller import JointTrajectoryControllerParameters
from armsim_ros.control.command_writer import CommandWriter, compact
from armsim_ros.control.controller_state import StateRecord, StateRing
from armsim_ros.control.events import EventQueue
from armsim_ros.control.hardware_interface import HardwareInterface
from armsim_ros.control.joint_properties import JointProperties
from armsim_ros.control.trajectory_execution import Phase, TrajectoryExecution
from armsim_ros.control.trajectory_goal import (
    GoalStatus,
    TrajectoryErrorCode,
    TrajectoryGoal,
    TrajectoryResult,
)
from armsim_ros.control.trajectory_requests import (
    CancelRequest,
    Request,
    ScalingRequest,
    StartRequest,
    StopRequest,
    superseded,
)
from armsim_ros.control.trajectory_setup import command_timeout, stop_brakes
from armsim_ros.control.wraparound import wrap_in_place

REQUESTS_PER_UPDATE = 64
"""More have to wait for the next update, so that a burst does not delay this one."""


class TrajectoryLoop:
    """
    The part of a trajectory controller that the control loop's thread runs.

    :param parameters: checked.
    :param hardware: states to read, commands to write.
    """

    def __init__(
        self,
        parameters: JointTrajectoryControllerParameters,
        hardware: HardwareInterface,
        properties: JointProperties,
        events: EventQueue,
        time_ns: int,
    ) -> None:
        """Allocate everything that updates need."""
        states, commands = parameters.state_interfaces, parameters.command_interfaces
        joints = len(parameters.joints)
        width = joints * (4 if 'effort' in commands else 3)
        velocity = 'velocity' in states and ('velocity' in commands or 'effort' in commands)
        acceleration = velocity and 'acceleration' in states and 'acceleration' in commands
        self.parameters = parameters
        self.ring = StateRing(joints, width, 1 + velocity + acceleration)
        self.writer = CommandWriter(parameters, hardware)
        self.execution = TrajectoryExecution(
            parameters,
            width,
            (True, velocity, acceleration),
            stop_brakes(parameters, properties, events, time_ns),
            events,
        )
        self._ahead = self.execution.ahead.reshape(-1, joints)
        index = compact([hardware.index[name] for name in parameters.joints])
        self._sources = [
            (row, hardware.state.of(kind), index)
            for row, kind in enumerate(('position', 'velocity', 'acceleration'))
            if kind in states
        ]
        self._continuous = properties.continuous
        self._wraps = len(properties.continuous) > 0
        self._events = events
        self._inbox: deque[Request] = deque()

    def post(self, request: Request) -> None:
        """Leave a request for the next update; any thread."""
        self._inbox.append(request)

    def activate(self, time_ns: int) -> None:
        """Hold where the last command is, or where the joints are."""
        self.abort_pending('the controller was not active')
        self.execution.cmd_timeout = command_timeout(self.parameters, self._events, time_ns)
        self.writer.reset()
        record = self.ring.open()
        self._read(record)
        hold = record.feedback[0].copy()
        if self.parameters.set_last_command_interface_value_as_state_on_activation:
            last = self.writer.last_positions()
            known = np.isfinite(last)
            hold[known] = last[known]
        self.execution.hold(hold, time_ns)
        record.reference[:] = self.execution.ahead
        self._compare(record)
        self._close(record, time_ns)

    def deactivate(self) -> None:
        """End all goals and let go of the joints."""
        message = 'the controller was deactivated'
        self.execution.end_goals(GoalStatus.ABORTED, message, TrajectoryErrorCode.INVALID_GOAL)
        self.abort_pending(message)
        self.writer.release()

    def update(self, time_ns: int, period: float) -> None:
        """Run one update, see :meth:`Controller.update`."""
        execution = self.execution
        record = self._begin(time_ns)
        execution.judge(record, time_ns)
        self._note(record, time_ns)
        execution.advance(period)
        self.writer.write(self._ahead, record.error, record.output, period)
        self.ring.close(record)

    def process_requests(self, time_ns: int) -> None:
        """Take requests up while time stands still."""
        if self._inbox:
            self._close(self._begin(time_ns), time_ns)

    def abort_pending(self, message: str) -> None:
        """End the goals that nobody has taken up yet; any thread."""
        while True:
            try:
                request = self._inbox.popleft()
            except IndexError:
                return
            goal = getattr(request, 'goal', None)
            if isinstance(goal, TrajectoryGoal) and not isinstance(request, CancelRequest):
                goal.finish(
                    GoalStatus.ABORTED,
                    TrajectoryResult(TrajectoryErrorCode.INVALID_GOAL, message),
                )

    def _begin(self, time_ns: int) -> StateRecord:
        execution = self.execution
        record = self.ring.open()
        record.reference[:] = execution.ahead
        self._read(record)
        self._compare(record)
        if self._inbox or execution.scheduled is not None:
            self._take_requests(record, time_ns)
            execution.start_scheduled(record, time_ns)
            record.reference[:] = execution.ahead
            self._compare(record)
        return record

    def _take_requests(self, record: StateRecord, time_ns: int) -> None:
        execution = self.execution
        inbox = self._inbox
        requests = [inbox.popleft() for _ in range(min(len(inbox), REQUESTS_PER_UPDATE))]
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
            elif isinstance(request, StopRequest):
                execution.stop_on_demand(request.goal, record, time_ns)
            elif isinstance(request, ScalingRequest):
                execution.scaling = request.factor
            else:
                self.parameters = execution.parameters = request.parameters
                self.writer.set_gains(request.parameters)
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
        if execution.phase is Phase.HOLDING:
            record.motion = None
            record.desired_time = record.actual_time = 0.0
        else:
            record.motion = execution.motion
            record.desired_time = execution.time
            record.actual_time = (time_ns - execution.begin_ns) * 1e-9

    def _close(self, record: StateRecord, time_ns: int) -> None:
        self._note(record, time_ns)
        self.ring.close(record)
