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

    def copy(self) -> tuple[StateRecord, Matrix] | None:
        """Return the newest record's scalars and a copy of its data; None before the first."""
        while True:
            record = self.latest
            if record is None:
                return None
            sequence = record.sequence
            copied = (_scalars(record), record.data.copy())
            if sequence >= 0 and record.sequence == sequence:
                return copied


_SCALARS = ('sequence', 'time_ns', 'desired_time', 'actual_time', 'scaling', 'motion', 'goal')


def _scalars(record: StateRecord) -> StateRecord:
    copy = StateRecord.__new__(StateRecord)
    for name in _SCALARS:
        setattr(copy, name, getattr(record, name))
    return copy


@dataclass(frozen=True, slots=True, eq=False)
class ControllerSnapshot:
    """
    Content of ``controller_state``, and of the feedback of a goal, which has efforts too.

    :param reference: where the joints should be now.
    :param feedback: where they are.
    :param error: reference minus feedback, the short way for continuous joints.
    :param output: what was commanded, NaN for joints that are not commanded.
    :param desired_time_from_start: of the trajectory, at its scaled pace [s].
    :param actual_time_from_start: since the trajectory started [s].
    :param desired_effort: (n,) of the trajectory, 0 without [N*m or N].
    :param commanded_effort: (n,) the same of what was commanded.
    :param sequence: number of the update.
    :param goal: active in that update; a new goal is not before its first.
    :param motion: the trajectory that runs, None while the joints are held.
    """

    time_ns: int
    joint_names: tuple[str, ...]
    reference: TrajectoryPoint
    feedback: TrajectoryPoint
    error: TrajectoryPoint
    output: TrajectoryPoint
    desired_time_from_start: float
    actual_time_from_start: float
    speed_scaling_factor: float
    desired_effort: Vector
    commanded_effort: Vector
    sequence: int
    goal: TrajectoryGoal | None = None
    motion: Motion | None = None


def snapshot_of(
    ring: StateRing, joint_names: tuple[str, ...], states: tuple[str, ...],
    commands: tuple[str, ...]
) -> ControllerSnapshot | None:
    """
    Return the newest state as an immutable value.

    :param states: interfaces that feedback and error have.
    :param commands: interfaces that output has.
    """
    copied = ring.copy()
    if copied is None:
        return None
    scalars, data = copied
    kinds = ('position', 'velocity', 'acceleration', 'effort')

    def point(first: int, have: tuple[str, ...]) -> TrajectoryPoint:
        rows = [data[first + i] if kind in have else np.empty(0) for i, kind in enumerate(kinds)]
        return TrajectoryPoint(*rows)

    efforts = np.zeros((2, len(joint_names)))
    if 'effort' in commands:
        efforts = data[[REFERENCE_EFFORT, ROWS - 1]]
    return ControllerSnapshot(
        scalars.time_ns, joint_names, point(REFERENCE, kinds[:3]), point(FEEDBACK, states),
        point(ERROR, states), point(OUTPUT, commands), scalars.desired_time, scalars.actual_time,
        scalars.scaling, efforts[0], efforts[1], scalars.sequence, scalars.goal, scalars.motion)


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
