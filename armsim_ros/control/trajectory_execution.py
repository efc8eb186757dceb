# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What a trajectory controller is doing: which motion runs, how far, and whether its goal is met.

Only the control loop's thread works here. ``ahead`` is the reference at the next update; in the
next update it is the reference at that time.

A new trajectory starts from the desired state, so that it goes on without a step. With a stamp
in the future the old motion (or the hold) goes on until then and is left on a segment to the
first point; with a stamp in the past the points that are over are left out, and a segment leads
to the first that is not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from armsim_ros.config.joint_trajectory_controller import JointTrajectoryControllerParameters
from armsim_ros.control.controller_state import StateRecord
from armsim_ros.control.events import EventQueue
from armsim_ros.control.sampling import Motion, PreparedTrajectory, TIME_RESOLUTION
from armsim_ros.control.stop_motion import deceleration, stop_ramp
from armsim_ros.control.tolerances import SegmentTolerances, ToleranceCheck
from armsim_ros.control.trajectory_goal import (
    GoalStatus,
    TrajectoryErrorCode,
    TrajectoryGoal,
    TrajectoryResult,
)

Vector = NDArray[np.float64]


class Phase(Enum):
    """HOLDING: no trajectory; RUNNING: it is judged; SETTLED: it was judged to have ended."""

    HOLDING = 'holding'
    RUNNING = 'running'
    SETTLED = 'settled'


@dataclass(frozen=True, slots=True, eq=False)
class StartRequest:
    """
    A trajectory on its way to the control loop.

    :param goal: None for a trajectory from the topic.
    :param step: whether a first point at time 0 is jumped to.
    """

    prepared: PreparedTrajectory
    stamp_ns: int
    tolerances: SegmentTolerances
    goal: TrajectoryGoal | None = None
    step: bool = False


class TrajectoryExecution:
    """
    Runs and judges trajectories of n joints.

    :param width: 3n, or 4n where the reference has effort.
    :param computed: which of position, velocity, acceleration have an error.
    :param brakes: (n,) decelerations for stops, or None to stop at once or by a ramp.
    """

    def __init__(
        self,
        parameters: JointTrajectoryControllerParameters,
        width: int,
        computed: Sequence[bool],
        brakes: Vector | None,
        events: EventQueue,
    ) -> None:
        """Start holding at zero; :meth:`hold` says where."""
        self.parameters = parameters
        self.joints = len(parameters.joints)
        self.scaling = parameters.speed_scaling.initial_scaling_factor
        self.cmd_timeout = 0.0
        self.phase = Phase.HOLDING
        self.goal: TrajectoryGoal | None = None
        self.scheduled: StartRequest | None = None
        self.ahead = np.zeros(width)
        self.motion = Motion.standing(self.ahead.copy())
        self.time = 0.0
        self.begin_ns = 0
        self._computed = tuple(computed)
        self._brakes = brakes
        self._events = events
        self._first = False
        self._goal_time = 0.0
        self._set_tolerances(SegmentTolerances.of(parameters))

    @property
    def active_goal(self) -> TrajectoryGoal | None:
        """The goal that is followed, or the one that waits for its stamp."""
        if self.goal is not None or self.scheduled is None:
            return self.goal
        return self.scheduled.goal

    def hold(self, positions: Vector, time_ns: int) -> None:
        """Stand at (n,) positions [rad or m]."""
        final = np.zeros(len(self.ahead))
        final[: self.joints] = positions
        self._set_motion(Motion.standing(final), 0.0, time_ns)
        self.phase = Phase.HOLDING

    def advance(self, period: float) -> None:
        """Go on by one period [s] at the present pace."""
        self.time += period * self.scaling
        self.motion.sample(self.time, self.ahead)

    def take(self, request: StartRequest, record: StateRecord, time_ns: int) -> None:
        """Start a new trajectory, or wait for its stamp while the old one goes on."""
        if request.goal is not None:
            self._drop_goals(request.goal)
            request.goal.execute()
        elif self.parameters.compat == 'ros1':
            self._finish_all(GoalStatus.CANCELED, 'a trajectory from the topic replaced the goal')
        elif self.scheduled is not None and self.scheduled.goal is not None:
            self.goal = self.scheduled.goal
        self.scheduled = None
        if request.stamp_ns > time_ns:
            self.scheduled = request
        else:
            self._begin(request, record, time_ns)

    def start_scheduled(self, record: StateRecord, time_ns: int) -> bool:
        """Start the waiting trajectory when its time has come."""
        request = self.scheduled
        if request is None or time_ns < request.stamp_ns:
            return False
        self.scheduled = None
        self._begin(request, record, time_ns)
        return True

    def cancel(self, goal: TrajectoryGoal, record: StateRecord, time_ns: int) -> bool:
        """Cancel a goal and stop; nothing happens where it is not the active one."""
        if goal is self.goal or (self.scheduled is not None and goal is self.scheduled.goal):
            self._finish_all(GoalStatus.CANCELED)
            self.stop(record, time_ns)
            return True
        return False

    def stop_on_demand(
        self, goal: TrajectoryGoal | None, record: StateRecord, time_ns: int
    ) -> None:
        """Cancel what runs and stop; the goal that asked for it succeeds."""
        self._finish_all(GoalStatus.CANCELED, 'an empty trajectory stopped the goal')
        self.stop(record, time_ns)
        if goal is not None:
            goal.execute()
            self._finish(
                goal, GoalStatus.SUCCEEDED, 'stopped: success', TrajectoryErrorCode.SUCCESSFUL
            )

    def abort(self, message: str) -> None:
        """End the active and the waiting goal because the controller cannot go on."""
        self._finish_all(GoalStatus.ABORTED, message, TrajectoryErrorCode.INVALID_GOAL)
        self.scheduled = None

    def stop(self, record: StateRecord, time_ns: int) -> None:
        """Come to rest: by deceleration, by the ramp, or at the measured position at once."""
        effort = len(self.ahead) > 3 * self.joints
        duration = self.parameters.stop_trajectory_duration
        if self._brakes is not None:
            motion = deceleration(
                record.feedback[0].copy(), record.feedback[1], self._brakes, effort=effort
            )
        elif duration > 0.0:
            reference = record.reference[: 2 * self.joints].reshape(2, -1)
            motion = stop_ramp(reference[0], reference[1], duration, effort=effort)
        else:
            final = np.zeros(len(self.ahead))
            final[: self.joints] = record.feedback[0]
            motion = Motion.standing(final)
        self._set_motion(motion, 0.0, time_ns)
        self.phase = Phase.HOLDING

    def judge(self, record: StateRecord, time_ns: int) -> None:
        """Compare the errors with the tolerances; end the goal when they decide it."""
        if self.phase is Phase.HOLDING:
            return
        over = self.time - self.motion.end
        before_end = over < -TIME_RESOLUTION
        if self.phase is Phase.RUNNING:
            if (before_end or self._first) and self._path.violated(record.error):
                text = f'path tolerance violated: {self._path.worst(record.error)}'
                self._fail(TrajectoryErrorCode.PATH_TOLERANCE_VIOLATED, text, record, time_ns)
                return
            self._first = False
            if not before_end and self._judge_end(over, record, time_ns):
                return
        timeout = self.cmd_timeout
        if timeout > 0.0 and over > timeout and (self.goal or not self._of_goal):
            text = (
                f'cmd_timeout exceeded: no new command for {over:.6f} s after the last waypoint, '
                f'allowed {timeout:g} s'
            )
            self._fail(TrajectoryErrorCode.GOAL_TOLERANCE_VIOLATED, text, record, time_ns)

    def _judge_end(self, over: float, record: StateRecord, time_ns: int) -> bool:
        if self._at_goal.violated(record.error):
            strict = self.parameters.compat == 'ros1' and self._goal_time == 0.0
            if not strict and not 0.0 < self._goal_time < over:
                return False
            text = (
                f'goal_time_tolerance exceeded: {over:.6f} s after the last waypoint '
                f'(allowed {self._goal_time:g} s) {self._at_goal.worst(record.error)}'
            )
            self._fail(TrajectoryErrorCode.GOAL_TOLERANCE_VIOLATED, text, record, time_ns)
            return True
        self.phase = Phase.SETTLED
        goal, self.goal = self.goal, None
        if goal is not None:
            self.motion.rest(self.joints)
            self._finish(
                goal, GoalStatus.SUCCEEDED, 'Goal reached: success',
                TrajectoryErrorCode.SUCCESSFUL,
            )  # fmt: skip
        return False

    def _begin(self, request: StartRequest, record: StateRecord, time_ns: int) -> None:
        time = (time_ns - request.stamp_ns) * 1e-9 if request.stamp_ns else 0.0
        if request.goal is not None:
            self.goal = request.goal
        if time > request.prepared.end:
            self._finish_all(
                GoalStatus.ABORTED,
                'the trajectory ended before it could be started',
                TrajectoryErrorCode.INVALID_GOAL,
            )
            return
        parameters = self.parameters
        state = record.reference.copy()
        if not (parameters.interpolate_from_desired_state or parameters.open_loop_control):
            state[:] = 0.0
            state[: self.joints] = record.feedback[0]
            if 'velocity' in parameters.state_interfaces:
                state[self.joints : 2 * self.joints] = record.feedback[1]
        held = record.reference[: self.joints]
        motion = request.prepared.begin(time, state, held, step=request.step)
        self._set_motion(motion, time, request.stamp_ns or time_ns)
        self.phase = Phase.RUNNING
        self._first = True
        self._of_goal = self.goal is not None
        if request.goal is not None or self.goal is None:
            self._set_tolerances(request.tolerances)

    def _set_motion(self, motion: Motion, time: float, begin_ns: int) -> None:
        self.motion = motion
        self.time = time
        self.begin_ns = begin_ns
        self._of_goal = False
        motion.sample(time, self.ahead)

    def _set_tolerances(self, tolerances: SegmentTolerances) -> None:
        names = self.parameters.joints
        self._path = ToleranceCheck(names, tolerances.path, self._computed)
        self._at_goal = ToleranceCheck(names, tolerances.goal, self._computed)
        self._goal_time = tolerances.goal_time

    def _fail(
        self, code: TrajectoryErrorCode, text: str, record: StateRecord, time_ns: int
    ) -> None:
        text += f', {self.time:.3f} s after the start of the trajectory'
        goal, self.goal = self.goal, None
        if goal is not None:
            self._finish(goal, GoalStatus.ABORTED, text, code)
            self._events.add(time_ns, 'error', 'goal_aborted', f'goal aborted: {text}')
        else:
            self._events.add(time_ns, 'error', 'tolerance', f'trajectory stopped: {text}')
        self.stop(record, time_ns)

    def _drop_goals(self, new: TrajectoryGoal) -> None:
        ros1 = self.parameters.compat == 'ros1'
        self._finish_all(
            GoalStatus.CANCELED if ros1 else GoalStatus.ABORTED,
            'preempted: a new goal was accepted',
            TrajectoryErrorCode.SUCCESSFUL if ros1 else TrajectoryErrorCode.INVALID_GOAL,
        )

    def _finish_all(
        self,
        status: GoalStatus,
        message: str = '',
        code: TrajectoryErrorCode = TrajectoryErrorCode.SUCCESSFUL,
    ) -> None:
        waiting = self.scheduled.goal if self.scheduled is not None else None
        self.scheduled = None
        goal, self.goal = self.goal, None
        for one in (goal, waiting):
            if one is not None:
                self._finish(one, status, message, code)

    @staticmethod
    def _finish(
        goal: TrajectoryGoal, status: GoalStatus, message: str, code: TrajectoryErrorCode
    ) -> None:
        goal.finish(status, TrajectoryResult(code, message))
