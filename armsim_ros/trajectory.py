# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The joint trajectory that planning makes and controllers run.

Plain values with the content of ``trajectory_msgs/msg/JointTrajectory``.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from armsim_ros.arrays import Vector


def _empty() -> Vector:
    return np.empty(0)


@dataclass(frozen=True, slots=True, eq=False)
class TrajectoryPoint:
    """
    One waypoint; a field that is not given has length 0.

    :param time_from_start: [s] after the trajectory's start.
    :param positions: (n,) [rad or m].
    :param velocities: (n,) [rad/s or m/s].
    :param accelerations: (n,) [rad/s^2 or m/s^2].
    :param effort: (n,) [N*m or N].
    """

    time_from_start: float
    positions: Vector = field(default_factory=_empty)
    velocities: Vector = field(default_factory=_empty)
    accelerations: Vector = field(default_factory=_empty)
    effort: Vector = field(default_factory=_empty)


@dataclass(frozen=True, slots=True, eq=False)
class JointTrajectory:
    """
    Waypoints for named joints; it is not checked here.

    :param joint_names: (n,) order of the values in every point.
    :param points: the waypoints.
    :param stamp_ns: [ns] when the trajectory starts; 0 is "as soon as it arrives".
    """

    joint_names: tuple[str, ...]
    points: tuple[TrajectoryPoint, ...] = ()
    stamp_ns: int = 0

    @property
    def duration(self) -> float:
        """Time of the last point [s], 0 for a trajectory without points."""
        return self.points[-1].time_from_start if self.points else 0.0

    def positions(self) -> Vector:
        """Return all positions as (points, n)."""
        return np.array([point.positions for point in self.points], dtype=np.float64)

    def times(self) -> Vector:
        """Return all times from start as (points,) [s]."""
        return np.array([point.time_from_start for point in self.points], dtype=np.float64)
