# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Which trajectories a controller takes.

Checks come in the order of ros2_controllers' joint_trajectory_controller. It does not have those
of names given twice and of numbers that are not finite.
"""

from __future__ import annotations

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.config.controllers.joint_trajectory_controller import (
    JointTrajectoryControllerParameters,
)
from armsim_ros.control.trajectory.goal import RefusedTrajectoryError, TrajectoryErrorCode
from armsim_ros.control.trajectory.waypoints import Waypoints
from armsim_ros.errors import nearest
from armsim_ros.trajectory import JointTrajectory

STANDING = 1.2e-7
"""A slower velocity at the last point counts as none [rad/s or m/s]; FLT_EPSILON upstream."""


def validate(
    trajectory: JointTrajectory,
    parameters: JointTrajectoryControllerParameters,
    now_ns: int,
) -> Waypoints:
    """
    Return a trajectory's waypoints in controller order.

    :param now_ns: the present time [ns].
    :raises RefusedTrajectoryError: the first error.
    """
    joints = parameters.joints
    names = trajectory.joint_names
    if len(names) != len(joints) and not parameters.allow_partial_joints_goal:
        raise RefusedTrajectoryError(
            f'the trajectory names {len(names)} joints ({_listed(names)}), the controller has '
            f'{len(joints)} ({_listed(joints)}), and allow_partial_joints_goal is false',
            TrajectoryErrorCode.INVALID_JOINTS,
        )
    if not names:
        raise RefusedTrajectoryError(
            'the trajectory names no joint', TrajectoryErrorCode.INVALID_JOINTS
        )
    if not len(trajectory):
        raise RefusedTrajectoryError('the trajectory has no points')
    _check_names(names, joints)
    _check_end(trajectory, parameters)
    if trajectory.stamp_ns and trajectory.duration * 1e9 < now_ns - trajectory.stamp_ns:
        raise RefusedTrajectoryError(
            f'the trajectory ended {(now_ns - trajectory.stamp_ns) * 1e-9 - trajectory.duration:g}'
            f' s ago: its stamp is {trajectory.stamp_ns * 1e-9:.3f} s, it lasts '
            f'{trajectory.duration:g} s, and it is {now_ns * 1e-9:.3f} s now; '
            'a stamp of 0 starts it at once',
            TrajectoryErrorCode.OLD_HEADER_TIMESTAMP,
        )
    _check_times(trajectory.times)
    if trajectory.fault:
        raise RefusedTrajectoryError(trajectory.fault)
    _check_quantities(trajectory, parameters)
    return Waypoints.of(trajectory, joints)


def _check_names(names: tuple[str, ...], joints: tuple[str, ...]) -> None:
    for name in names:
        if name not in joints:
            hint = nearest(name, joints)
            raise RefusedTrajectoryError(
                f"joint '{name}' is not among the controller's joints ({_listed(joints)})"
                f'{"; " if hint else ""}{hint}',
                TrajectoryErrorCode.INVALID_JOINTS,
            )
        if names.count(name) > 1:
            raise RefusedTrajectoryError(
                f"joint '{name}' is named {names.count(name)} times",
                TrajectoryErrorCode.INVALID_JOINTS,
            )


def _check_end(
    trajectory: JointTrajectory, parameters: JointTrajectoryControllerParameters
) -> None:
    if parameters.allow_nonzero_velocity_at_trajectory_end or trajectory.velocities is None:
        return
    for name, velocity in zip(trajectory.joint_names, trajectory.velocities[-1], strict=True):
        if abs(velocity) > STANDING:
            raise RefusedTrajectoryError(
                f"the last point moves joint '{name}' with velocity {velocity:g}; allowed: 0, "
                'unless allow_nonzero_velocity_at_trajectory_end is true'
            )


def _check_times(times: Vector) -> None:
    for i in 1 + np.flatnonzero(np.diff(times) <= 0.0):
        raise RefusedTrajectoryError(
            f'time_from_start of point {i} is {times[i]:g} s, not after the '
            f'{times[i - 1]:g} s of point {i - 1}; allowed: increasing times'
        )


def _check_quantities(
    trajectory: JointTrajectory, parameters: JointTrajectoryControllerParameters
) -> None:
    integrating = parameters.allow_integration_in_goal_trajectories
    for i, point in enumerate(trajectory.points()):
        if not len(point.positions) and not integrating:
            raise RefusedTrajectoryError(
                f'point {i} has no positions; allowed: {len(trajectory.joint_names)}, unless '
                'allow_integration_in_goal_trajectories is true'
            )
        if not any(map(len, (point.positions, point.velocities, point.accelerations))):
            raise RefusedTrajectoryError(
                f'point {i} has neither positions nor velocities nor accelerations'
            )
        if len(point.effort) and 'effort' not in parameters.command_interfaces:
            raise RefusedTrajectoryError(
                f'point {i} has efforts, but the controller commands '
                f'{_listed(parameters.command_interfaces)} only; leave effort empty'
            )


def _listed(names: tuple[str, ...]) -> str:
    return ', '.join(names) if names else 'none'
