# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where a running trajectory will be, or was, at a given time."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.control.trajectory.controller_state import StateRing
from armsim_ros.control.trajectory.sampling import TIME_RESOLUTION


def _empty() -> Vector:
    return np.empty(0)


@dataclass(frozen=True, slots=True, eq=False)
class QueryResult:
    """Answer to ``query_state``; the message says why there is no state."""

    success: bool
    message: str = ''
    names: tuple[str, ...] = ()
    positions: Vector = field(default_factory=_empty)
    velocities: Vector = field(default_factory=_empty)
    accelerations: Vector = field(default_factory=_empty)


def query(ring: StateRing, names: tuple[str, ...], time_ns: int) -> QueryResult:
    """
    Sample the trajectory that runs or has ended last.

    :param names: (n,) joints of the controller.
    :param time_ns: absolute time [ns]; a changed pace is taken to stay as it is now.
    """
    copied = ring.copy()
    motion = copied[0].motion if copied else None
    if copied is None or motion is None:
        return QueryResult(False, 'no trajectory is running: the joints are held')
    now = copied[0]
    time = now.desired_time + (time_ns - now.time_ns) * 1e-9 * now.scaling
    if time < motion.start - TIME_RESOLUTION:
        return QueryResult(
            False, f'{time_ns * 1e-9:.6f} s is {motion.start - time:.6f} s before the trajectory'
        )
    if time > motion.end + TIME_RESOLUTION:
        return QueryResult(
            False,
            f'{time_ns * 1e-9:.6f} s is {time - motion.end:.6f} s after the last waypoint',
        )
    values = motion.at(min(max(time, motion.start), motion.end))
    n = len(names)
    return QueryResult(True, '', names, values[:n], values[n : 2 * n], values[2 * n : 3 * n])
