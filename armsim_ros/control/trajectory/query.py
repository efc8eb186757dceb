# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where a running trajectory will be, or was, at a given time."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.control.trajectory.controller_state import ControllerSnapshot
from armsim_ros.control.trajectory.sampling import TIME_RESOLUTION


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
    return QueryResult(
        success, text, names, values[:n], values[n : 2 * n], values[2 * n : 3 * n])
