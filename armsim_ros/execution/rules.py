# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Rules of trajectory execution: what may start, how long it may take, when it is done."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
import math

import numpy as np

from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.model.robot_model import JointType, RobotModel
from armsim_ros.trajectory import JointTrajectory, TrajectoryPoint

_SOURCE = 'trajectory execution'

STATES_AT_REST = 3
"""How many joint states in a row have to be without motion."""


def check_sizes(trajectory: JointTrajectory) -> None:
    """
    Refuse a trajectory whose points do not fit its joint names.

    :raises PlanningError: CONTROL_FAILED with the point and the sizes.
    """
    count = len(trajectory.joint_names)
    if len(set(trajectory.joint_names)) != count:
        raise PlanningError(
            MoveItErrorCode.CONTROL_FAILED,
            f'the trajectory names a joint twice: {", ".join(trajectory.joint_names)}', _SOURCE,
        )
    for k, point in enumerate(trajectory.points):
        if len(point.positions) != count:
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                f'point {k} of the trajectory has {len(point.positions)} positions for {count} '
                'joint names', _SOURCE,
            )
        for what in ('velocities', 'accelerations', 'effort'):
            given = len(getattr(point, what))
            if given not in (0, count):
                raise PlanningError(
                    MoveItErrorCode.CONTROL_FAILED,
                    f'point {k} of the trajectory has {given} {what} for {count} joint names',
                    _SOURCE,
                )
        if not np.all(np.isfinite(point.positions)):
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                f'point {k} of the trajectory has a position that is not a finite number',
                _SOURCE,
            )


def check_start(
    trajectory: JointTrajectory, measured: Mapping[str, float], robot: RobotModel,
    tolerance: float, joint_tolerances: Mapping[str, float] | None = None,
) -> None:
    """
    Refuse a trajectory that begins away from where the robot is.

    :param measured: joint -> position [rad or m].
    :param tolerance: largest distance [rad or m]; 0 skips the check.
    :param joint_tolerances: joint -> its own tolerance; 0 skips that joint.
    :raises PlanningError: CONTROL_FAILED with joint, expected and actual position.
    """
    own = joint_tolerances or {}
    if not trajectory.points:
        return
    for name, expected in zip(
        trajectory.joint_names, trajectory.points[0].positions, strict=True
    ):
        allowed = own.get(name, tolerance)
        if allowed <= 0.0 or name not in measured:
            continue
        off = float(expected) - measured[name]
        if robot.joints[name].type is JointType.CONTINUOUS:
            off = math.remainder(off, 2.0 * math.pi)
        if abs(off) > allowed:
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                f"Invalid Trajectory: start point deviates from current robot state: joint "
                f"'{name}' expected {float(expected):.5f}, is {measured[name]:.5f}, off by "
                f'{abs(off):.5f}, allowed {allowed:g}; plan again from the current state, or '
                'raise trajectory_execution.allowed_start_tolerance', _SOURCE,
            )


def continues(first: JointTrajectory, second: JointTrajectory, tolerance: float) -> bool:
    """
    Return whether a trajectory begins where another one ends, for the joints of both.

    :param tolerance: largest distance [rad or m].
    """
    ends = dict(zip(first.joint_names, first.points[-1].positions, strict=True))
    begins = zip(second.joint_names, second.points[0].positions, strict=True)
    return all(abs(ends[name] - begin) <= tolerance for name, begin in begins if name in ends)


def unwound(
    trajectory: JointTrajectory, measured: Mapping[str, float], robot: RobotModel
) -> JointTrajectory:
    """
    Return the trajectory with continuous joints free of jumps, from where they are.

    :param measured: joint -> position [rad or m]; the first point lies within half a turn of it.
    """
    turning = [
        k for k, name in enumerate(trajectory.joint_names)
        if robot.joints[name].type is JointType.CONTINUOUS
    ]
    if not turning or not trajectory.points:
        return trajectory
    last = trajectory.points[0].positions.copy()
    for k in turning:
        last[k] = measured.get(trajectory.joint_names[k], float(last[k]))
    points = []
    for point in trajectory.points:
        positions = point.positions.copy()
        for k in turning:
            positions[k] = last[k] + math.remainder(float(positions[k] - last[k]), 2.0 * math.pi)
        points.append(TrajectoryPoint(
            point.time_from_start, positions, point.velocities, point.accelerations, point.effort
        ))
        last = positions
    return JointTrajectory(trajectory.joint_names, tuple(points), trajectory.stamp_ns)


def allowed_duration(trajectory: JointTrajectory, scaling: float, margin: float) -> float:
    """
    Return how long the execution may take [s].

    :param scaling: factor of the trajectory's own duration.
    :param margin: added to it [s].
    """
    return trajectory.duration * scaling + margin


def settled(states: Sequence[Mapping[str, float]], tolerance: float) -> bool:
    """
    Return whether the robot rests: the last states differ by no more than a tolerance.

    :param states: joint -> position [rad or m], the newest last.
    :param tolerance: [rad or m].
    """
    if len(states) < STATES_AT_REST:
        return False
    recent = states[-STATES_AT_REST:]
    return all(
        abs(state[name] - recent[0][name]) <= tolerance
        for state in recent[1:] for name in recent[0] if name in state
    )
