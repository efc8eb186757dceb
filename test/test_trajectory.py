# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The arrays of a joint trajectory."""

import numpy as np
import pytest

from armsim_ros.errors import TrajectoryError
from armsim_ros.trajectory import JointTrajectory, TrajectoryPoint

TIMES = np.array([0.0, 1.0, 2.0])
POSITIONS = np.arange(6.0).reshape(3, 2)


def test_arrays_are_copies_that_nobody_changes():
    """What the caller does with his arrays afterwards changes no trajectory."""
    given = POSITIONS.copy()
    trajectory = JointTrajectory(('a', 'b'), TIMES, given)
    given[:] = 9.0
    np.testing.assert_array_equal(trajectory.positions, POSITIONS)
    with pytest.raises(ValueError, match='read-only'):
        trajectory.positions[0] = 1.0


@pytest.mark.parametrize(('arrays', 'sentence'), [
    ({'positions': POSITIONS.T}, r'positions .* shape \(2, 3\); allowed: \(3, 2\)'),
    ({'velocities': POSITIONS[:2]}, r'velocities .* shape \(2, 2\)'),
    ({'times': TIMES[:2]}, r'positions .* allowed: \(2, 2\)'),
    ({'times': [0.0, 1.0, np.inf]}, 'the time of point 2 is inf; allowed: finite'),
    ({'positions': np.where(POSITIONS == 3.0, np.nan, POSITIONS)},
     "point 1 has nan among its positions, for joint 'b'"),
])
def test_what_is_no_trajectory_is_refused(arrays, sentence):
    """A wrong shape or number is told, with what is allowed."""
    with pytest.raises(TrajectoryError, match=sentence):
        JointTrajectory(('a', 'b'), **{'times': TIMES, 'positions': POSITIONS, **arrays})


def test_points_may_give_different_quantities():
    """A row of NaN stands for what a point does not give, None for what none gives."""
    trajectory = JointTrajectory.of_points(('a',), [0.5, 1.0], [
        TrajectoryPoint(np.ones(1), np.zeros(1)), TrajectoryPoint(np.zeros(1))])
    np.testing.assert_array_equal(trajectory.velocities, [[0.0], [np.nan]])
    assert trajectory.accelerations is None
    assert [len(point.velocities) for point in trajectory.points()] == [1, 0]


def test_a_part_keeps_times_and_stamp():
    """Later waypoints and some of the joints are chosen without a change of times."""
    whole = JointTrajectory(('a', 'b'), TIMES, POSITIONS, stamp_ns=7)
    part = whole.since(1).of_joints(['b'])
    assert (part.joint_names, part.stamp_ns, part.velocities) == (('b',), 7, None)
    np.testing.assert_array_equal(part.times, [1.0, 2.0])
    np.testing.assert_array_equal(part.positions, [[3.0], [5.0]])


def test_an_empty_trajectory():
    """Without waypoints it has no length and no duration."""
    trajectory = JointTrajectory(('a', 'b'))
    assert (len(trajectory), trajectory.duration) == (0, 0.0)
    assert trajectory.positions.shape == (0, 2)
