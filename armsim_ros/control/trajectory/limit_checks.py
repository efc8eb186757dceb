# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a trajectory keeps the limits of the joints, from where they are on."""

from __future__ import annotations

import numpy as np

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.config.controllers.joint_trajectory_controller import (
    JointTrajectoryControllerParameters,
)
from armsim_ros.control.joint_properties import JointProperties
from armsim_ros.control.trajectory import wraparound
from armsim_ros.control.trajectory.goal import RefusedTrajectoryError
from armsim_ros.control.trajectory.requests import TrajectoryStart
from armsim_ros.control.trajectory.waypoints import Waypoints

POSITION_SLACK = 1e-3
"""So far outside its limits a position is still taken: rounding by planners [rad or m]."""
VELOCITY_SLACK = 1.01
"""So much above its limit a velocity is still taken."""
LATENCY = 0.1
"""So old may the state be from which a client planned for a moving joint [s]."""


def check_limits(waypoints: Waypoints, properties: JointProperties) -> None:
    """
    Refuse positions and velocities beyond the limits of the joints.

    Velocities are those that the points give, and the mean ones from point to point.

    :raises RefusedTrajectoryError: the first that is beyond.
    """
    positions = waypoints.positions
    for outside, limit in (
        (positions < properties.lower - POSITION_SLACK, properties.lower),
        (positions > properties.upper + POSITION_SLACK, properties.upper),
    ):
        for i, j in np.argwhere(outside):
            raise RefusedTrajectoryError(
                f"point {i} moves joint '{properties.names[j]}' to {positions[i, j]:g} "
                f'{properties.units[j]}, beyond its limit {limit[j]:g}'
            )
    bound = properties.velocity * VELOCITY_SLACK
    for i, j in np.argwhere(np.abs(waypoints.velocities) > bound):
        raise RefusedTrajectoryError(
            f"point {i} moves joint '{properties.names[j]}' with velocity "
            f'{waypoints.velocities[i, j]:g}; allowed: up to {properties.velocity[j]:g} '
            f'{properties.units[j]}/s'
        )
    mean = np.diff(positions, axis=0) / np.diff(waypoints.times)[:, None]
    for i, j in np.argwhere(np.abs(mean) > bound):
        raise RefusedTrajectoryError(
            f"joint '{properties.names[j]}' would need a velocity of {mean[i, j]:g} between "
            f'points {i} and {i + 1}; allowed: up to {properties.velocity[j]:g} '
            f'{properties.units[j]}/s'
        )


def check_start(
    waypoints: Waypoints,
    elapsed: float,
    reference: Matrix,
    measured: Vector,
    guarded: Mask,
    parameters: JointTrajectoryControllerParameters,
    properties: JointProperties,
) -> TrajectoryStart:
    """
    Refuse a trajectory whose first point cannot be reached in its time.

    A joint that something blocks stands away from its reference; those who plan read where it
    stands. So the first point may be near either.

    :param elapsed: time since its stamp [s], 0 without one; points before are left out.
    :param reference: (2, n) position and velocity that the joints should have now.
    :param measured: (n,) positions that they have.
    :param guarded: (n,) joints with a path tolerance: it ends a goal that jumps away, without a
        motion, so they are not refused here.
    :raises RefusedTrajectoryError: the first joint that is too far away.
    """
    allowed = parameters.allowed_start_step
    nowhere = np.zeros(len(measured), dtype=bool)
    first = int(np.searchsorted(waypoints.times, elapsed)) if elapsed > 0.0 else 0
    if first == len(waypoints.times):
        return TrajectoryStart(nowhere, jump=False)
    time = float(waypoints.times[first]) - elapsed
    if allowed == 0.0 or (time > 0.0 and not parameters.enforce_joint_limits):
        return TrajectoryStart(nowhere, jump=time == 0.0)
    reach = allowed + np.abs(reference[1]) * LATENCY
    if time > 0.0:
        reach = reach + properties.velocity * time
    far = waypoints.positions[first] - np.stack((reference[0], measured))
    far[:, properties.continuous] = wraparound.shortest(far[:, properties.continuous])
    beyond = np.abs(far) > reach
    bad = beyond.all(axis=0)
    for i in np.flatnonzero(bad & ~guarded):
        raise RefusedTrajectoryError(
            f'the first point, in {time:g} s, is {far[1, i]:g} {properties.units[i]} away from '
            f"where joint '{properties.names[i]}' is; allowed: {reach[i]:g}; give it more time, "
            'or start the trajectory where the arm is'
        )
    return TrajectoryStart(beyond[0] & ~bad, jump=time == 0.0 and bool(bad.any()))
