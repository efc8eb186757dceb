# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What is recorded of a motion."""

from types import SimpleNamespace

import pytest
from small_arms import planar_arm

from armsim_ros.nodes.move_group.execution.trajectory_monitor import TrajectoryMonitor

SECOND = 1_000_000_000


@pytest.fixture
def states():
    """Return what the monitor needs of the state monitor."""
    return SimpleNamespace(recorders=[])


@pytest.fixture
def hear(states):
    """Return a function that hands on the positions of joints at a time [s]."""
    def hear(seconds, **positions):
        for record in states.recorders:
            record(round(seconds * SECOND), positions)

    return hear


@pytest.fixture(scope='module')
def robot():
    """Return an arm of three joints."""
    return planar_arm()


def test_positions_have_the_times_of_their_messages(states, hear, robot):
    """From the first of them on, in the order of the joints."""
    with TrajectoryMonitor(states, robot, 1000.0) as monitor:
        hear(7.0, axis2=2.0, axis1=1.0, axis3=3.0, other=9.0)
        hear(7.5, axis2=5.0, axis1=4.0, axis3=6.0, other=9.0)
    assert monitor.trajectory.joint_names == ('axis1', 'axis2', 'axis3')
    assert monitor.trajectory.times.tolist() == [0.0, 0.5]
    assert monitor.trajectory.positions.tolist() == [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]


def test_no_more_than_the_frequency(states, hear, robot):
    """What comes too early is left out, and what is older than the last."""
    with TrajectoryMonitor(states, robot, 10.0) as monitor:
        for seconds in (1.0, 1.05, 1.1, 1.04, 1.15, 1.3):
            hear(seconds, axis1=seconds)
    assert monitor.trajectory.positions[:, 0].tolist() == [1.0, 1.1, 1.3]


def test_all_active_joints_of_the_robot_are_recorded(states, hear, robot):
    """
    Also those that the motion leaves alone; one that nobody measures is at its default.

    Upstream: plan_execution.cpp, executeAndMonitor (a trajectory without a group).
    """
    with TrajectoryMonitor(states, robot, 10.0) as monitor:
        hear(1.0, axis1=1.0)
    assert monitor.trajectory.joint_names == tuple(robot.active_joints)
    assert monitor.trajectory.positions.tolist() == [[1.0, 0.0, 0.0]]


def test_nothing_is_recorded_after_the_end(states, hear, robot):
    """The states of the next motion are left out."""
    with TrajectoryMonitor(states, robot, 10.0) as monitor:
        hear(1.0, axis1=1.0)
    hear(2.0, axis1=2.0)
    assert len(monitor.trajectory) == 1


def test_a_frequency_of_zero_records_nothing(states, hear, robot):
    """That is the default."""
    with TrajectoryMonitor(states, robot, 0.0) as monitor:
        hear(1.0, axis1=1.0)
    assert len(monitor.trajectory) == 0
    assert states.recorders == []
