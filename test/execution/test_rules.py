# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of the rules of trajectory execution."""

import math

import numpy as np
import pytest

from armsim_ros.errors import PlanningError
from armsim_ros.execution.rules import (
    allowed_duration,
    check_points,
    check_start,
    settled,
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
        check_start(trajectory([0.0, 0.52, 0.0]), measured, planar.robot, 0.01)
    assert caught.value.code == -4
    assert "'axis2' expected 0.52000, is 0.50000" in str(caught.value)


def test_start_tolerance_of_one_joint(planar):
    """EXE-5: a joint's own tolerance goes before the common one."""
    measured = {'axis1': 0.0, 'axis2': 0.5, 'axis3': 0.0}
    check_start(trajectory([0.0, 0.52, 0.0]), measured, planar.robot, 0.01, {'axis2': 0.05})


def test_start_tolerance_zero_skips_the_check(planar):
    """EXE-5: tolerance 0 accepts any start."""
    check_start(trajectory([0.0, 2.0, 0.0]), dict.fromkeys(NAMES, 0.0), planar.robot, 0.0)


def test_allowed_duration():
    """EXE-8: duration times scaling plus margin."""
    assert allowed_duration(trajectory([0.0] * 3, [1.0] * 3), 1.2, 0.5) == pytest.approx(1.7)


def test_rest_needs_three_equal_states():
    """EXE-9: three states in a row without motion beyond the tolerance."""
    still, moved = {'axis1': 1.0}, {'axis1': 1.05}
    assert not settled([still, still], 0.01)
    assert not settled([still, moved, still], 0.01)
    assert settled([moved, still, still, still], 0.01)


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
    check_start(trajectory([0.0, 0.0, 0.0]), measured, turning, 0.01)
