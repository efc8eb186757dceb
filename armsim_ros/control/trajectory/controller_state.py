# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What a trajectory controller did in its last update, readable from other threads.

The control loop writes into a ring of records and then names the newest. A reader copies the
newest with a single call and checks that it was not written again meanwhile; neither waits.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.control.trajectory.goal import TrajectoryGoal
from armsim_ros.control.trajectory.sampling import Motion, TIME_RESOLUTION
from armsim_ros.trajectory import TrajectoryPoint

RECORDS = 8
REFERENCE, REFERENCE_EFFORT, FEEDBACK, ERROR, OUTPUT, ROWS = 0, 3, 4, 7, 10, 14
#: Interfaces of a joint, in the order of the rows.
KINDS = ('position', 'velocity', 'acceleration', 'effort')


class StateRecord:
    """
    An update: (14, n) rows and the times that belong to it.

    Rows: reference position, velocity, acceleration, effort; feedback position, velocity,
    acceleration; error of the same three; output position, velocity, acceleration, effort.
    ``motion`` is the trajectory that runs, None while the joints are held;
    ``goal`` the active goal.
    """

    __slots__ = (
        'actual_time', 'compared', 'data', 'desired_time', 'error', 'feedback', 'goal',
        'motion', 'output', 'reference', 'scaling', 'sequence', 'time_ns')

    def __init__(self, joints: int, width: int, compared: int) -> None:
        """
        Make all arrays once.

        :param width: 3n, or 4n where the reference has effort.
        :param compared: quantities that have an error: 1 for position, 2 with velocity, 3.
        """
        self.data = np.full((ROWS, joints), np.nan)
        self.data[ERROR:OUTPUT] = 0.0
        self.reference = self.data.reshape(-1)[:width]
        self.feedback = self.data[FEEDBACK:ERROR]
        self.error = self.data[ERROR:OUTPUT]
        self.output = self.data[OUTPUT:]
        self.compared = (
            self.data[REFERENCE : REFERENCE + compared], self.data[FEEDBACK : FEEDBACK + compared],
            self.data[ERROR : ERROR + compared])
        self.sequence = -1
        self.time_ns = 0
        self.desired_time = 0.0
        self.actual_time = 0.0
        self.scaling = 1.0
        self.motion: Motion | None = None
        self.goal: TrajectoryGoal | None = None

    def measured_state(self) -> Vector:
        """Return feedback as (w,) like the reference: velocity where available, else 0."""
        state = np.zeros_like(self.reference)
        joints = self.feedback.shape[1]
        state[:joints] = self.feedback[0]
        state[joints : 2 * joints] = np.nan_to_num(self.feedback[1])
        return state


class StateRing:
    """The last records; a single thread writes."""

    def __init__(self, joints: int, width: int, compared: int) -> None:
        """Make all records, see :class:`StateRecord`."""
        self._records = [StateRecord(joints, width, compared) for _ in range(RECORDS)]
        self._sequence = 0
        self.latest: StateRecord | None = None

    def open(self) -> StateRecord:
        """Return the record to write next."""
        record = self._records[self._sequence % RECORDS]
        record.sequence = -1
        return record

    def close(self, record: StateRecord) -> None:
        """Make a record the newest."""
        record.sequence = self._sequence
        self._sequence += 1
        self.latest = record


@dataclass(frozen=True, slots=True, eq=False)
class ControllerSnapshot:
    """
    Content of ``controller_state``, and of the feedback of a goal, which has efforts too.

    :param data: (14, n) rows of a :class:`StateRecord` [rad or m, per s, per s^2; N*m or N].
    :param state_interfaces: what feedback and error have.
    :param command_interfaces: what the output has.
    :param desired_time_from_start: of the trajectory, at its scaled pace [s].
    :param actual_time_from_start: since the trajectory started [s].
    :param sequence: number of the update.
    :param goal: active in that update; a new goal is not before its first.
    :param motion: the trajectory that runs, None while the joints are held.
    """

    time_ns: int
    joint_names: tuple[str, ...]
    data: Matrix
    state_interfaces: tuple[str, ...]
    command_interfaces: tuple[str, ...]
    desired_time_from_start: float
    actual_time_from_start: float
    speed_scaling_factor: float
    sequence: int
    goal: TrajectoryGoal | None = None
    motion: Motion | None = None

    @property
    def reference(self) -> TrajectoryPoint:
        """Desired state of the joints (n,) now."""
        return self._point(REFERENCE, KINDS[:3])

    @property
    def feedback(self) -> TrajectoryPoint:
        """Measured state (n,)."""
        return self._point(FEEDBACK, self.state_interfaces)

    @property
    def error(self) -> TrajectoryPoint:
        """Reference minus feedback (n,), the short way for continuous joints."""
        return self._point(ERROR, self.state_interfaces)

    @property
    def output(self) -> TrajectoryPoint:
        """Commands (n,), NaN for joints that are not commanded."""
        return self._point(OUTPUT, self.command_interfaces)

    @property
    def desired_effort(self) -> Vector:
        """Of the trajectory (n,), 0 without [N*m or N]."""
        return self._effort(REFERENCE_EFFORT)

    @property
    def commanded_effort(self) -> Vector:
        """Of what was commanded (n,), 0 without [N*m or N]."""
        return self._effort(ROWS - 1)

    def _point(self, first: int, have: tuple[str, ...]) -> TrajectoryPoint:
        return TrajectoryPoint(*(
            self.data[first + i] if kind in have else np.empty(0)
            for i, kind in enumerate(KINDS)))

    def _effort(self, row: int) -> Vector:
        commanded = 'effort' in self.command_interfaces
        return self.data[row] if commanded else np.zeros(len(self.joint_names))


def snapshot_of(
    ring: StateRing, joint_names: tuple[str, ...], states: tuple[str, ...],
    commands: tuple[str, ...]
) -> ControllerSnapshot | None:
    """
    Return the newest state as an immutable value.

    :param states: interfaces that feedback and error have.
    :param commands: interfaces that output has.
    """
    while True:
        record = ring.latest
        if record is None:
            return None
        sequence = record.sequence
        snapshot = ControllerSnapshot(
            record.time_ns, joint_names, record.data.copy(), states, commands,
            record.desired_time, record.actual_time, record.scaling, sequence, record.goal,
            record.motion)
        if sequence >= 0 and record.sequence == sequence:
            return snapshot


def _empty() -> Vector:
    return np.empty(0)


@dataclass(frozen=True, slots=True, eq=False)
class QueryResult:
    """
    Answer to ``query_state``.

    Outside of a trajectory ``success`` is false and the message has the reason; the state is that
    which is measured, or the last point. Only an inactive controller gives none.
    """

    success: bool
    message: str = ''
    names: tuple[str, ...] = ()
    positions: Vector = field(default_factory=_empty)
    velocities: Vector = field(default_factory=_empty)
    accelerations: Vector = field(default_factory=_empty)


def query(snapshot: ControllerSnapshot, time_ns: int) -> QueryResult:
    """
    Sample the trajectory that runs.

    :param snapshot: the newest.
    :param time_ns: absolute time [ns]; a changed pace is taken to stay as it is now.
    """
    names, motion = snapshot.joint_names, snapshot.motion
    if motion is None:
        held = snapshot.reference
        return QueryResult(False, 'no trajectory is running: the joints are held', names,
                           held.positions, held.velocities, held.accelerations)
    passed = (time_ns - snapshot.time_ns) * 1e-9 * snapshot.speed_scaling_factor
    time = snapshot.desired_time_from_start + passed
    if time < motion.start - TIME_RESOLUTION:
        text = f'{time_ns * 1e-9:.6f} s is {motion.start - time:.6f} s before the trajectory'
        measured = snapshot.feedback
        return QueryResult(
            False, text, names, measured.positions, measured.velocities, measured.accelerations)
    over = time - motion.end
    values = motion.final
    text = f'{time_ns * 1e-9:.6f} s is {over:.6f} s after the last waypoint'
    success = over <= TIME_RESOLUTION
    if success:
        values, text = motion.at(min(max(time, motion.start), motion.end)), ''
    n = len(names)
    return QueryResult(success, text, names, values[:n], values[n : 2 * n], values[2 * n : 3 * n])
