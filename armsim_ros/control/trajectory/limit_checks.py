# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where a trajectory exceeds the limits of the joints, from where they are on."""

from __future__ import annotations

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.control.joint_properties import JointProperties
from armsim_ros.control.trajectory import wraparound
from armsim_ros.control.trajectory.requests import TrajectoryStart
from armsim_ros.control.trajectory.waypoints import Waypoints

POSITION_SLACK = 1e-3
"""So far outside its limits a position still counts as inside: rounding by planners [rad or m]."""
VELOCITY_SLACK = 1.01
"""So much above its limit a velocity still counts as below it."""
LATENCY = 0.1
"""So old may the state be from which a client planned for a moving joint [s]."""
START_STEP = 0.05
"""So far from the joint the first point may be without any time to get there [rad or m]."""


def beyond_limits(waypoints: Waypoints, properties: JointProperties) -> str:
    """
    Return the first position or velocity beyond the limits of the joints, '' where none is.

    Velocities are those that the points give, and the mean ones from point to point.
    """
    positions, times = waypoints.positions, waypoints.times
    for outside, limit in (
        (positions < properties.lower - POSITION_SLACK, properties.lower),
        (positions > properties.upper + POSITION_SLACK, properties.upper),
    ):
        for i, j in np.argwhere(outside):
            return (
                f"point {i} at {times[i]:g} s moves joint '{properties.names[j]}' to "
                f'{positions[i, j]:g} {properties.units[j]}, beyond its limit {limit[j]:g}'
            )
    bound = properties.velocity * VELOCITY_SLACK
    for i, j in np.argwhere(np.abs(waypoints.velocities) > bound):
        return (
            f"point {i} at {times[i]:g} s moves joint '{properties.names[j]}' with velocity "
            f'{waypoints.velocities[i, j]:g}, above its limit {properties.velocity[j]:g} '
            f'{properties.units[j]}/s'
        )
    mean = np.diff(positions, axis=0) / np.diff(times)[:, None]
    for i, j in np.argwhere(np.abs(mean) > bound):
        return (
            f"joint '{properties.names[j]}' needs a velocity of {mean[i, j]:g} between points {i} "
            f'and {i + 1} ({times[i]:g} s to {times[i + 1]:g} s), above its limit '
            f'{properties.velocity[j]:g} {properties.units[j]}/s'
        )
    return ''


def start_of(
    waypoints: Waypoints,
    elapsed: float,
    reference: Matrix,
    measured: Vector,
    properties: JointProperties,
) -> tuple[TrajectoryStart, str]:
    """
    Return from where the joints begin, and which cannot reach the first point in its time.

    A joint that something blocks is away from its reference; planners read its measured
    position. So the first point may be near either.

    :param elapsed: time since its stamp [s], 0 if unstamped; points before are left out.
    :param reference: (2, n) position and velocity that the joints should have now.
    :param measured: (n,) positions that they have.
    """
    nowhere = np.zeros(len(measured), dtype=bool)
    first = int(np.searchsorted(waypoints.times, elapsed)) if elapsed > 0.0 else 0
    if first == len(waypoints.times):
        return TrajectoryStart(nowhere, jump=False), ''
    time = max(float(waypoints.times[first]) - elapsed, 0.0)
    reach = START_STEP + np.abs(reference[1]) * LATENCY
    if time > 0.0:
        reach = reach + properties.velocity * time
    far = waypoints.positions[first] - np.stack((reference[0], measured))
    far[:, properties.continuous] = wraparound.shortest(far[:, properties.continuous])
    beyond = np.abs(far) > reach
    bad = beyond.all(axis=0)
    start = TrajectoryStart(beyond[0] & ~bad, jump=time == 0.0 and bool(bad.any()))
    if not bad.any():
        return start, ''
    i = int(np.argmax(bad))
    return start, (
        f'the first point, in {time:g} s, is {far[1, i]:g} {properties.units[i]} away from '
        f"joint '{properties.names[i]}', which can move {reach[i]:g} in that time; give it more "
        'time, or start the trajectory where the arm is'
    )
