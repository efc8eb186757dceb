# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of the rules of trajectory execution."""

from dataclasses import replace
import math

import numpy as np
import pytest

from armsim_ros.errors import PlanningError
from armsim_ros.execution.rules import (
    allowed_duration,
    check_points,
    check_start,
    continues,
    settled,
    Tolerances,
    unwound,
)
from armsim_ros.trajectory import JointTrajectory, TrajectoryPoint

NAMES = ('axis1', 'axis2', 'axis3')


def trajectory(*rows, names=NAMES):
    """Return points one second apart."""
    points = [TrajectoryPoint(np.array(row)) for row in rows]
    return JointTrajectory.of_points(names, range(len(rows)), points)


def test_sizes_that_differ_are_refused():
    """EXE-6: a point with fewer positions than joint names is refused with both numbers."""
    with pytest.raises(PlanningError, match='point 1 has 2 positions for 3 joints'):
        check_points(trajectory([0.0, 0.0, 0.0], [1.0, 1.0]))


def test_a_joint_named_twice_is_refused():
    """A trajectory in which two columns are the same joint cannot be run."""
    with pytest.raises(PlanningError, match='twice'):
        check_points(trajectory([0.0, 0.0], names=('axis1', 'axis1')))


def test_start_far_away_is_refused_with_numbers(planar):
    """EXE-5: the first point may not be further from the measured state than the tolerance."""
    measured = {'axis1': 0.0, 'axis2': 0.5, 'axis3': 0.0}
    with pytest.raises(PlanningError) as caught:
        check_start(trajectory([0.0, 0.52, 0.0]), measured, planar.robot, Tolerances(0.01))
    assert caught.value.code == -4
    assert "'axis2' expected 0.52000, is 0.50000" in str(caught.value)


def test_start_tolerance_of_one_joint(planar):
    """
    A joint's own tolerance goes before the common one.

    Upstream: trajectory_execution_manager.cpp, getAllowedStartToleranceJoint.
    """
    measured = {'axis1': 0.0, 'axis2': 0.5, 'axis3': 0.0}
    check_start(trajectory([0.0, 0.52, 0.0]), measured, planar.robot,
                Tolerances(0.01, {'axis2': 0.05}))


def test_start_tolerance_zero_skips_the_check(planar):
    """
    Tolerance 0 accepts any start, unless a joint has a tolerance of its own.

    Upstream: trajectory_execution_manager.cpp, validate.
    """
    there, away = dict.fromkeys(NAMES, 0.0), trajectory([0.0, 2.0, 0.0])
    check_start(away, there, planar.robot, Tolerances(0.0))
    assert Tolerances(0.0).unchecked
    for own in ({'axis1': 0.1}, {'axis2': 0.1}):
        assert not Tolerances(0.0, own).unchecked
    check_start(away, there, planar.robot, Tolerances(0.0, {'axis1': 0.1}))
    with pytest.raises(PlanningError, match='axis2'):
        check_start(away, there, planar.robot, Tolerances(0.0, {'axis2': 0.1}))
    check_start(away, there, planar.robot, Tolerances(0.1, {'axis2': 0.0}))


def test_joints_that_are_never_published_are_at_their_default(planar):
    """
    A joint without a measured position is compared with its default.

    Upstream: trajectory_execution_manager.cpp, validate; current_state_monitor.cpp.
    """
    check_start(trajectory([0.0, 0.0, 0.0]), {}, planar.robot, Tolerances(0.01))
    with pytest.raises(PlanningError, match="'axis3'"):
        check_start(trajectory([0.0, 0.0, 0.5]), {}, planar.robot, Tolerances(0.01))


def test_first_point_without_positions(planar):
    """
    It is refused where the start is checked, and only there.

    Upstream: trajectory_execution_manager.cpp, validate.
    """
    bare = JointTrajectory(
        NAMES, np.array([0.0]), np.full((1, 3), np.nan), np.array([[0.1, 0.0, 0.0]]))
    check_points(bare)
    check_start(bare, {}, planar.robot, Tolerances(0.0))
    with pytest.raises(PlanningError, match='no positions for 3 joints'):
        check_start(bare, {}, planar.robot, Tolerances(0.01))


def test_allowed_duration():
    """EXE-8: duration times scaling plus margin."""
    assert allowed_duration(trajectory([0.0] * 3, [1.0] * 3), 1.2, 0.5) == pytest.approx(1.7)


def test_a_start_ahead_counts():
    """
    Where the header's stamp is ahead, the wait for it is part of the duration.

    Upstream: trajectory_execution_manager.cpp, executePart.
    """
    ahead = replace(trajectory([0.0] * 3, [1.0] * 3), stamp_ns=5_000_000_000)
    assert allowed_duration(ahead, 1.2, 0.5, 3_000_000_000) == pytest.approx(3.0 * 1.2 + 0.5)
    assert allowed_duration(ahead, 1.2, 0.5, 9_000_000_000) == pytest.approx(1.7)


def test_rest_needs_three_states_without_motion(planar):
    """
    Three states in a row in which no joint of the trajectory has moved by its tolerance.

    Upstream: trajectory_execution_manager.cpp, waitForRobotToStop.
    """
    def rests(*positions, **own):
        states = [{'axis1': value, 'axis2': 7.0 * k} for k, value in enumerate(positions)]
        return settled(states, ('axis1',), planar.robot, Tolerances(0.01, own))

    assert not rests(1.0, 1.0, 1.0)
    assert rests(1.0, 1.0, 1.0, 1.0)
    assert rests(1.0, 1.009, 1.018, 1.027)
    assert not rests(1.0, 1.05, 1.0, 1.0)
    assert rests(1.0, 1.05, 1.0, 1.0, axis1=0.06)
    assert not rests(1.0, 1.0, 1.0, 1.001, axis1=0.0)


def test_unwound_starts_near_the_measured_turn(turning):
    """EXE-13: a continuous joint starts within half a turn of its measured value."""
    measured = {'axis1': 6.2, 'axis2': 0.0, 'axis3': 0.0}
    result = unwound(trajectory([-0.08, 0.0, 0.0], [0.3, 0.0, 0.0]), measured, turning)
    assert result.positions[:, 0] == pytest.approx(np.array([-0.08, 0.3]) + 2 * math.pi)


def test_unwound_has_no_jump(turning):
    """EXE-13: points that cross half a turn follow one another without a jump."""
    rows = [[3.0, 0.0, 0.0], [-3.2, 0.0, 0.0], [-2.9, 0.0, 0.0]]
    result = unwound(trajectory(*rows), {'axis1': 3.0}, turning)
    assert np.abs(np.diff(result.positions[:, 0])).max() < 0.5


def test_start_check_of_a_continuous_joint_is_modulo_a_turn(turning):
    """EXE-5: a continuous joint one turn away is at its start."""
    measured = {'axis1': 2 * math.pi, 'axis2': 0.0, 'axis3': 0.0}
    check_start(trajectory([0.0, 0.0, 0.0]), measured, turning, Tolerances(0.01))


def test_a_trajectory_that_continues_another_one():
    """It begins within the tolerance of the other's end, for the joints that both have."""
    first = trajectory([0.0, 0.0, 0.0], [1.0, 2.0, 3.0])
    assert continues(first, trajectory([1.009, 1.991, 3.0], [5.0] * 3), 0.01)
    assert not continues(first, trajectory([1.0, 2.02, 3.0]), 0.01)
    assert continues(first, trajectory([3.0, 1.0], names=('axis3', 'axis1')), 0.01)
    assert not continues(first, trajectory([3.1, 9.0], names=('axis3', 'other')), 0.01)
    assert continues(first, trajectory([9.0], names=('other',)), 0.01)
