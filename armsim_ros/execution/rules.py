# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Rules of trajectory execution: what may start, how long it may take, when it is done."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
import math

import numpy as np

from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.model.robot_model import JointType, RobotModel
from armsim_ros.trajectory import JointTrajectory

_SOURCE = 'trajectory execution'

STATES_AT_REST = 3
"""How many joint states in a row have to be without motion."""


def check_points(trajectory: JointTrajectory) -> None:
    """
    Refuse a trajectory whose points do not fit its joint names, or lack positions.

    :raises PlanningError: CONTROL_FAILED with the point and what is wrong with it.
    """
    fault = trajectory.fault
    if len(set(trajectory.joint_names)) != len(trajectory.joint_names):
        fault = f'a joint is named twice: {", ".join(trajectory.joint_names)}'
    lacking = np.flatnonzero(np.isnan(trajectory.positions).any(axis=1))
    if not fault and len(lacking):
        fault = f'point {lacking[0]} has no positions'
    if fault:
        raise PlanningError(
            MoveItErrorCode.CONTROL_FAILED, f'the trajectory cannot be executed: {fault}', _SOURCE
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
    if not len(trajectory):
        return
    for name, expected in zip(trajectory.joint_names, trajectory.positions[0], strict=True):
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
    ends = dict(zip(first.joint_names, first.positions[-1], strict=True))
    begins = zip(second.joint_names, second.positions[0], strict=True)
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
    if not turning or not len(trajectory):
        return trajectory
    positions = trajectory.positions.copy()
    for k in turning:
        last = measured.get(trajectory.joint_names[k], float(positions[0, k]))
        for row in positions:
            last = row[k] = last + math.remainder(float(row[k] - last), 2.0 * math.pi)
    return replace(trajectory, positions=positions)


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
