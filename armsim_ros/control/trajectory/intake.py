# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The border between senders of trajectories and the control loop: what is accepted."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.controllers.joint_trajectory_controller import (
    JointTrajectoryControllerParameters,
)
from armsim_ros.control.hardware_interface import JointProperties
from armsim_ros.control.trajectory.controller_state import ControllerSnapshot
from armsim_ros.control.trajectory.goal import (
    RefusedTrajectoryError,
    StartRequest,
    StopRequest,
    TrajectoryErrorCode,
    TrajectoryGoal,
    TrajectoryStart,
)
from armsim_ros.control.trajectory.sampling import PreparedTrajectory
from armsim_ros.control.trajectory.tolerances import JointTolerance, SegmentTolerances
from armsim_ros.control.trajectory.waypoints import shortest, Waypoints
from armsim_ros.errors import nearest
from armsim_ros.trajectory import JointTrajectory

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
                f'{positions[i, j]:g} {properties.units[j]}, beyond its limit {limit[j]:g}')
    bound = properties.velocity * VELOCITY_SLACK
    for i, j in np.argwhere(np.abs(waypoints.velocities) > bound):
        return (
            f"point {i} at {times[i]:g} s moves joint '{properties.names[j]}' with velocity "
            f'{waypoints.velocities[i, j]:g}, above its limit {properties.velocity[j]:g} '
            f'{properties.units[j]}/s')
    mean = np.diff(positions, axis=0) / np.diff(times)[:, None]
    for i, j in np.argwhere(np.abs(mean) > bound):
        return (
            f"joint '{properties.names[j]}' needs a velocity of {mean[i, j]:g} between points {i} "
            f'and {i + 1} ({times[i]:g} s to {times[i + 1]:g} s), above its limit '
            f'{properties.velocity[j]:g} {properties.units[j]}/s')
    return ''


def start_of(
    waypoints: Waypoints, elapsed: float, reference: Matrix, measured: Vector,
    properties: JointProperties
) -> tuple[TrajectoryStart, str]:
    """
    Return from where the joints begin, and which cannot reach the first point in its time.

    A joint that something blocks is away from its reference; planners read its measured
    position. So the first point may be near either.

    :param elapsed: time since its stamp [s], negative before it, 0 if unstamped; points before
        it are left out.
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
    far[:, properties.continuous] = shortest(far[:, properties.continuous])
    beyond = np.abs(far) > reach
    bad = beyond.all(axis=0)
    start = TrajectoryStart(beyond[0] & ~bad, jump=time == 0.0 and bool(bad.any()))
    if not bad.any():
        return start, ''
    i = int(np.argmax(bad))
    return start, (
        f'the first point, in {time:g} s, is {far[1, i]:g} {properties.units[i]} away from '
        f"joint '{properties.names[i]}', which can move {reach[i]:g} in that time; give it more "
        'time, or start the trajectory where the arm is')


STANDING = 1.2e-7
"""A slower velocity at the last point counts as none [rad/s or m/s]; FLT_EPSILON upstream."""


def validate(
    trajectory: JointTrajectory, parameters: JointTrajectoryControllerParameters, now_ns: int
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
            TrajectoryErrorCode.INVALID_JOINTS)
    if not names:
        raise RefusedTrajectoryError(
            'the trajectory names no joint', TrajectoryErrorCode.INVALID_JOINTS)
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
            TrajectoryErrorCode.OLD_HEADER_TIMESTAMP)
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
                TrajectoryErrorCode.INVALID_JOINTS)
        if names.count(name) > 1:
            raise RefusedTrajectoryError(
                f"joint '{name}' is named {names.count(name)} times",
                TrajectoryErrorCode.INVALID_JOINTS)


def _check_end(
    trajectory: JointTrajectory, parameters: JointTrajectoryControllerParameters
) -> None:
    if parameters.allow_nonzero_velocity_at_trajectory_end or trajectory.velocities is None:
        return
    for name, velocity in zip(trajectory.joint_names, trajectory.velocities[-1], strict=True):
        if abs(velocity) > STANDING:
            raise RefusedTrajectoryError(
                f"the last point moves joint '{name}' with velocity {velocity:g}; allowed: 0, "
                'unless allow_nonzero_velocity_at_trajectory_end is true')


def _check_times(times: Vector) -> None:
    for i in 1 + np.flatnonzero(np.diff(times) <= 0.0):
        raise RefusedTrajectoryError(
            f'time_from_start of point {i} is {times[i]:g} s, not after the '
            f'{times[i - 1]:g} s of point {i - 1}; allowed: increasing times')


def _check_quantities(
    trajectory: JointTrajectory, parameters: JointTrajectoryControllerParameters
) -> None:
    integrating = parameters.allow_integration_in_goal_trajectories
    for i, point in enumerate(trajectory.points()):
        if not len(point.positions) and not integrating:
            raise RefusedTrajectoryError(
                f'point {i} has no positions; allowed: {len(trajectory.joint_names)}, unless '
                'allow_integration_in_goal_trajectories is true')
        if not any(map(len, (point.positions, point.velocities, point.accelerations))):
            raise RefusedTrajectoryError(
                f'point {i} has neither positions nor velocities nor accelerations')
        if len(point.effort) and 'effort' not in parameters.command_interfaces:
            raise RefusedTrajectoryError(
                f'point {i} has efforts, but the controller commands '
                f'{_listed(parameters.command_interfaces)} only; leave effort empty')


def _listed(names: tuple[str, ...]) -> str:
    return ', '.join(names) if names else 'none'


class TrajectoryIntake:
    """
    Turns trajectories into requests.

    :param properties: types and limits of the controller's joints.
    :param snapshot: gives the newest state of the controller.
    """

    def __init__(
        self, properties: JointProperties, snapshot: Callable[[], ControllerSnapshot | None]
    ) -> None:
        self._properties, self._snapshot = properties, snapshot

    def topic(
        self, trajectory: JointTrajectory, parameters: JointTrajectoryControllerParameters,
        now_ns: int
    ) -> tuple[StartRequest | StopRequest, str]:
        """
        Return the request for a trajectory from the topic, and which limit it exceeds.

        The tolerances are those of the parameters.

        :raises RefusedTrajectoryError: the trajectory is not taken.
        """
        if parameters.compat == 'ros1' and not len(trajectory):
            return StopRequest(None), ''
        tolerances = SegmentTolerances.of(parameters)
        return self._request(trajectory, parameters, now_ns, tolerances, None)

    def goal(
        self, trajectory: JointTrajectory, path: Sequence[JointTolerance],
        goal: Sequence[JointTolerance], goal_time: float,
        parameters: JointTrajectoryControllerParameters, now_ns: int
    ) -> tuple[StartRequest | StopRequest, TrajectoryGoal, list[str]]:
        """
        Return the request for a goal, the goal, and warnings: tolerances, limits.

        :raises RefusedTrajectoryError: the trajectory is not taken.
        """
        defaults = SegmentTolerances.of(parameters)
        tolerances, complaint = defaults.overridden(parameters.joints, path, goal, goal_time)
        warnings = [f"the goal's tolerances are replaced by the defaults: {complaint}"]
        warnings = warnings if complaint else []
        accepted = TrajectoryGoal(trajectory, tolerances)
        if (
            parameters.compat == 'ros1'
            and not len(trajectory)
            and set(trajectory.joint_names) == set(parameters.joints)
        ):
            return StopRequest(accepted), accepted, warnings
        request, beyond = self._request(trajectory, parameters, now_ns, tolerances, accepted)
        return request, accepted, [*warnings, *([beyond] if beyond else [])]

    def _request(
        self, trajectory: JointTrajectory, parameters: JointTrajectoryControllerParameters,
        now_ns: int, tolerances: SegmentTolerances, goal: TrajectoryGoal | None
    ) -> tuple[StartRequest, str]:
        waypoints = validate(trajectory, parameters, now_ns)
        beyond, start = beyond_limits(waypoints, self._properties), None
        prepared = PreparedTrajectory(
            waypoints, self._properties.continuous,
            splines=parameters.interpolation_method == 'splines',
            effort='effort' in parameters.command_interfaces,
            rest_at_end='position' in parameters.command_interfaces)
        snapshot = self._snapshot()
        if prepared.start_ns(trajectory.stamp_ns) <= now_ns and snapshot is not None:
            elapsed = (now_ns - trajectory.stamp_ns) * 1e-9 if trajectory.stamp_ns else 0.0
            reference = np.stack((snapshot.reference.positions, snapshot.reference.velocities))
            start, far = start_of(
                waypoints, elapsed, reference, snapshot.feedback.positions, self._properties)
            beyond = beyond or far
        if beyond and parameters.reject_beyond_limits:
            raise RefusedTrajectoryError(f'{beyond}; reject_beyond_limits is true')
        return StartRequest(prepared, trajectory.stamp_ns, tolerances, goal, start), beyond
