# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Trajectories as messages and as values."""

import numpy as np
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMessage

from armsim_ros.nodes.conversions.trajectory import (
    trajectory_from_message,
    trajectory_to_message,
)
from armsim_ros.trajectory import JointTrajectory, TrajectoryPoint


def test_a_trajectory_goes_there_and_back() -> None:
    """Names, stamp, times and all given fields survive."""
    trajectory = JointTrajectory(
        ('b', 'a'),
        (
            TrajectoryPoint(0.5, np.array([1.0, 2.0]), np.array([0.1, 0.2])),
            TrajectoryPoint(1.25, np.array([3.0, 4.0]), np.array([0.0, 0.0])),
        ),
        stamp_ns=5_000_000_001,
    )
    back = trajectory_from_message(trajectory_to_message(trajectory))
    assert back.joint_names == ('b', 'a')
    assert back.stamp_ns == 5_000_000_001
    assert back.times().tolist() == [0.5, 1.25]
    assert back.positions().tolist() == [[1.0, 2.0], [3.0, 4.0]]
    assert back.points[0].velocities.tolist() == [0.1, 0.2]
    assert back.points[0].accelerations.size == 0
    assert back.points[0].effort.size == 0


def test_nothing_is_checked_here() -> None:
    """NaN and wrong sizes pass: refusing them, with a reason, is the controller's work."""
    message = JointTrajectoryMessage(joint_names=['a', 'a'])
    message.points = [trajectory_to_message(
        JointTrajectory(('a',), (TrajectoryPoint(-1.0, np.array([np.nan])),))
    ).points[0]]
    trajectory = trajectory_from_message(message)
    assert trajectory.joint_names == ('a', 'a')
    assert trajectory.points[0].time_from_start == -1.0
    assert np.isnan(trajectory.points[0].positions).all()


def test_values_do_not_share_memory_with_the_message() -> None:
    """A message may be reused while the trajectory runs."""
    message = trajectory_to_message(
        JointTrajectory(('a',), (TrajectoryPoint(1.0, np.array([1.0])),))
    )
    trajectory = trajectory_from_message(message)
    message.points[0].positions[0] = 9.0
    assert trajectory.points[0].positions[0] == 1.0
