# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What a trajectory controller is doing: which motion runs, how far, and for which goal.

Only the control loop's thread works here. ``ahead`` is the reference at the next update; in the
next update it is the reference at that time.

A new trajectory starts from the desired state, so that it goes on without a step. With a stamp
in the future the old motion (or the hold) goes on until then and is left on a segment to the
first point; where that point is at the stamp itself, the segment begins at once. With a stamp in
the past the points that are over are left out, and a segment leads to the first that is not; if
all are over, the joints are at the last at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.controllers.joint_trajectory_controller import (
    JointTrajectoryControllerParameters,
)
from armsim_ros.control.controller import NEVER_NS, Rate
from armsim_ros.control.mailbox import EventQueue, GoalStatus
from armsim_ros.control.trajectory.controller_state import StateRecord
from armsim_ros.control.trajectory.goal import (
    StartRequest,
    SUCCESS,
    timed_out,
    ToleranceMonitor,
    TrajectoryErrorCode,
    TrajectoryGoal,
    TrajectoryResult,
    Verdict,
)
from armsim_ros.control.trajectory.sampling import (
    deceleration,
    Motion,
    standstill,
    stop_ramp,
    TIME_RESOLUTION,
)
from armsim_ros.control.trajectory.tolerances import SegmentTolerances, ToleranceCheck

#: References that are computed at once [updates].
LOOK_AHEAD = 40
#: Checks of the goal tolerance after a trajectory from the topic has ended [Hz].
LATE_CHECKS = 100.0
#: A trajectory from the topic whose stamp is less than this ahead begins at once where it replaces
#: a waiting goal: the client's clock is ahead, and none of its stream would ever begin [ns].
STREAM_AHEAD_NS = 1_000_000_000


class Phase(Enum):
    """
    HOLDING: no trajectory, or its goal has succeeded; RUNNING: its tolerances are checked.

    A trajectory from the topic goes on running after its end.
    """

    HOLDING = 'holding'
    RUNNING = 'running'


class TrajectoryExecution:
    """
    Runs trajectories of n joints and ends their goals.

    :param width: 3n, or 4n where the reference has effort.
    :param computed: which of position, velocity, acceleration have an error.
    :param brakes: (n,) decelerations for stops, or None to stop at once or by a ramp.
    """

    def __init__(
        self, parameters: JointTrajectoryControllerParameters, width: int,
        computed: Sequence[bool], brakes: Vector | None, events: EventQueue
    ) -> None:
        """Start holding at zero; see :meth:`hold`."""
        self.parameters = parameters
        self.joints = len(parameters.joints)
        self.scaling = parameters.initial_pace
        self.cmd_timeout = 0.0
        self.phase = Phase.HOLDING
        self.goal: TrajectoryGoal | None = None
        self.scheduled: StartRequest | None = None
        self.ahead = np.zeros(width)
        self.motion = Motion.standing(self.ahead.copy())
        self._times: list[float] = []
        self._table = self.ahead[None, :]
        self._row, self._step = 0, 0.0
        self.time = 0.0
        self.begin_ns = 0
        self._goal_taken_ns = 0
        self._computed = tuple(computed)
        self._brakes, self._events = brakes, events
        self._monitor = self._new_monitor(SegmentTolerances.of(parameters))
        self._late_checks = Rate(LATE_CHECKS, aligned=True)

    @property
    def active_goal(self) -> TrajectoryGoal | None:
        """The goal that is followed, or the goal that waits for its stamp."""
        if self.goal is not None or self.scheduled is None:
            return self.goal
        return self.scheduled.goal

    def next_update(self, time_ns: int) -> int:
        """Return from when on an update matters [ns]: not while the joints are held."""
        if self.scheduled is not None or not self.motion.over(self.time):
            return time_ns
        if self.phase is not Phase.RUNNING:
            return NEVER_NS
        if self.goal is not None or self.cmd_timeout > 0.0:
            return time_ns
        due_ns = self._late_checks.next_due_ns(time_ns) if self._monitor.can_fail_at_end else None
        return NEVER_NS if due_ns is None else due_ns

    def hold(self, positions: Vector, time_ns: int) -> None:
        """Stay at (n,) positions [rad or m]."""
        self._set_motion(standstill(positions, len(self.ahead)), 0.0, time_ns)
        self.phase = Phase.HOLDING

    def advance(self, period: float) -> None:
        """Advance by a period [s] at the present pace."""
        if self.motion.over(self.time):
            self.time += period * self.scaling
            self.ahead[:] = self.motion.final
        else:
            self._look_ahead(period)
            self._go_to(self._row + 1)

    def coming(self, period: float, most: int) -> Matrix:
        """
        Return the references of the next updates (k, w), the present first.

        They hold while there are no requests and the path tolerances are kept, and only
        updates before the last waypoint are among them.

        :param period: from update to update [s].
        :param most: requested references.
        """
        nothing = self.ahead[None, :][:0]
        if self.phase is not Phase.RUNNING or self.scheduled is not None:
            return nothing
        if self._monitor.first or self.motion.over(self.time):
            return nothing
        self._look_ahead(period, most)
        row = self._row
        before_end = self.motion.end - TIME_RESOLUTION
        most = min(most, len(self._times) - row)
        while most > 0 and self._times[row + most - 1] >= before_end:
            most -= 1
        return self._table[row : row + most] if most > 1 else nothing

    def go_on(self, updates: int) -> None:
        """Take note of updates whose references were known."""
        self._go_to(self._row + updates)

    @property
    def path_check(self) -> ToleranceCheck:
        """The monitor of the errors on the way."""
        return self._monitor.path

    def pass_time(self, duration: float) -> None:
        """Let a time [s] go by in which nothing changes."""
        self.time += duration * self.scaling
        self._times = []

    def take(self, request: StartRequest, record: StateRecord, time_ns: int) -> None:
        """Start a new trajectory, or wait for its stamp while the old trajectory goes on."""
        if request.goal is not None:
            self._preempt()
            request.goal.execute()
            self._goal_taken_ns = time_ns
        elif self.active_goal is not None and 0 < request.stamp_ns < self._goal_taken_ns:
            # A stream that began before the goal did must not take the arm away from it.
            text = 'a trajectory from the topic was dropped: it is older than the goal'
            self._events.add(time_ns, 'info', 'trajectory_rejected', text)
            return
        elif self.parameters.compat == 'ros1':
            self.end_goals(GoalStatus.CANCELED, 'a trajectory from the topic replaced the goal')
        else:
            self.goal = self.active_goal
        replaces = self.scheduled is not None and self.scheduled.goal is None
        streams = replaces and request.stamp_ns - time_ns < STREAM_AHEAD_NS
        self.scheduled = None
        if request.start_ns > time_ns and not (streams and request.goal is None):
            self.scheduled = request
        else:
            self._begin(request, record, time_ns)

    def pass_over(self, request: StartRequest) -> None:
        """Treat a trajectory as replaced, without ever moving along it."""
        if request.goal is not None:
            self._preempt()
            request.goal.execute()
            self.goal = request.goal

    def start_scheduled(self, record: StateRecord, time_ns: int) -> None:
        """Start the waiting trajectory when its time has come."""
        request = self.scheduled
        if request is not None and time_ns >= request.stamp_ns:
            self.scheduled = None
            self._begin(request, record, time_ns)

    def cancel(self, goal: TrajectoryGoal, record: StateRecord, time_ns: int) -> None:
        """Cancel a goal and stop; nothing happens if it is not active."""
        if goal is self.active_goal:
            self.end_goals(GoalStatus.CANCELED)
            self.stop(record, time_ns)

    def stop_on_demand(
        self, goal: TrajectoryGoal | None, record: StateRecord, time_ns: int
    ) -> None:
        """Cancel what runs and stop; the goal that asked for it succeeds."""
        self.end_goals(GoalStatus.CANCELED, 'an empty trajectory stopped the goal')
        self.stop(record, time_ns)
        if goal is not None:
            goal.execute()
            _finish(goal, GoalStatus.SUCCEEDED, 'stopped: success', TrajectoryErrorCode.SUCCESSFUL)

    def stop(self, record: StateRecord, time_ns: int) -> None:
        """Come to rest: by deceleration, by the ramp, or at the measured position at once."""
        width = len(self.ahead)
        measured = record.feedback
        duration = self.parameters.stop_trajectory_duration
        if self._brakes is not None:
            motion = deceleration(measured[0], measured[1], self._brakes, width)
        elif duration > 0.0:
            reference = record.reference[: 2 * self.joints].reshape(2, -1)
            motion = stop_ramp(reference[0], reference[1], duration, width)
        else:
            motion = standstill(measured[0], width)
        self._set_motion(motion, 0.0, time_ns)
        self.phase = Phase.HOLDING

    def check(self, record: StateRecord, time_ns: int) -> None:
        """Compare the errors with the tolerances; end the goal when they decide it."""
        if self.phase is not Phase.RUNNING:
            return
        over = self.time - self.motion.end
        late = self.goal is None and self.cmd_timeout <= 0.0 and self.motion.over(self.time)
        if late and not self._monitor.first and not self._late_checks.due(time_ns):
            return
        verdict = self._monitor.check(record.error, over)
        if verdict is SUCCESS and self.goal is not None:
            if missed := self._monitor.missed(record.error):
                self._events.warn(time_ns, f'goal succeeded, but {missed}')
            self._succeed(self.goal, time_ns)
            return
        if verdict is None or verdict is SUCCESS:
            verdict = timed_out(over, self.cmd_timeout)
        if verdict is not None:
            self._fail(verdict, record, time_ns)

    def end_goals(
        self, status: GoalStatus, message: str = '',
        code: TrajectoryErrorCode = TrajectoryErrorCode.SUCCESSFUL
    ) -> None:
        """End the active goal and the waiting goal, and forget the waiting trajectory."""
        waiting = self.scheduled.goal if self.scheduled is not None else None
        self.scheduled = None
        goal, self.goal = self.goal, None
        for ended in (goal, waiting):
            if ended is not None:
                _finish(ended, status, message, code)

    def _preempt(self) -> None:
        ros1 = self.parameters.compat == 'ros1'
        self.end_goals(
            GoalStatus.CANCELED if ros1 else GoalStatus.ABORTED,
            'preempted: a new goal was accepted',
            TrajectoryErrorCode.SUCCESSFUL if ros1 else TrajectoryErrorCode.INVALID_GOAL)

    def _begin(self, request: StartRequest, record: StateRecord, time_ns: int) -> None:
        time = (time_ns - request.stamp_ns) * 1e-9 if request.stamp_ns else 0.0
        if request.goal is not None:
            self.goal = request.goal
        held = record.reference[: self.joints].copy()
        parameters = self.parameters
        desired = parameters.interpolate_from_desired_state or parameters.open_loop_control
        state = record.reference.copy() if desired else record.measured_state()
        start = request.start
        if start is not None and start.measured.any():
            rows = np.tile(start.measured, len(state) // self.joints)
            state[rows] = record.measured_state()[rows]
        motion = request.prepared.begin(time, state, held, step=start is not None and start.jump)
        self._set_motion(motion, time, request.stamp_ns or time_ns)
        self.phase = Phase.RUNNING
        self._monitor = self._new_monitor((self.goal or request).tolerances)

    def _set_motion(self, motion: Motion, time: float, begin_ns: int) -> None:
        self.motion = motion
        self.time = time
        self.begin_ns = begin_ns
        self._times = []
        self._late_checks = Rate(LATE_CHECKS, aligned=True)
        self.ahead[:] = motion.at(time)

    def _look_ahead(self, period: float, count: int = 2) -> None:
        """Have so many references, from the present on, in the table."""
        step = period * self.scaling
        if self._row + count <= len(self._times) and step == self._step:
            return
        times = [self.time]
        for _ in range(max(LOOK_AHEAD, count)):
            times.append(times[-1] + step)
        self._step, self._times, self._row = step, times, 0
        self._table = self.motion.samples(np.array(times))
        self._table[0] = self.ahead

    def _go_to(self, row: int) -> None:
        self._row = row
        self.time = self._times[row]
        self.ahead[:] = self._table[row]

    def _new_monitor(self, tolerances: SegmentTolerances) -> ToleranceMonitor:
        parameters = self.parameters
        return ToleranceMonitor(
            parameters.joints, self._computed, tolerances, strict=parameters.compat == 'ros1')

    def _succeed(self, goal: TrajectoryGoal, time_ns: int) -> None:
        final = self.motion.final.copy()
        final[self.joints : 3 * self.joints] = 0.0
        self._set_motion(Motion.standing(final), 0.0, time_ns)
        self.phase, self.goal = Phase.HOLDING, None
        _finish(goal, GoalStatus.SUCCEEDED, SUCCESS.text, SUCCESS.code)

    def _fail(self, verdict: Verdict, record: StateRecord, time_ns: int) -> None:
        text = f'{verdict.text}, {self.time:.3f} s after the start of the trajectory'
        goal, self.goal = self.goal, None
        if goal is not None:
            _finish(goal, GoalStatus.ABORTED, text, verdict.code)
            self._events.add(time_ns, 'error', 'goal_aborted', f'goal aborted: {text}')
        else:
            self._events.add(time_ns, 'error', 'tolerance', f'trajectory stopped: {text}')
        self.stop(record, time_ns)


def _finish(
    goal: TrajectoryGoal, status: GoalStatus, message: str, code: TrajectoryErrorCode
) -> None:
    goal.finish(status, TrajectoryResult(code, message))
