# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What is recorded of a motion."""

from types import SimpleNamespace

import pytest

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


def test_positions_have_the_times_of_their_messages(states, hear):
    """From the first of them on, in the order of the joints."""
    with TrajectoryMonitor(states, ('a', 'b'), 1000.0) as monitor:
        hear(7.0, b=2.0, a=1.0, c=9.0)
        hear(7.5, b=4.0, a=3.0, c=9.0)
    assert monitor.trajectory.joint_names == ('a', 'b')
    assert monitor.trajectory.times.tolist() == [0.0, 0.5]
    assert monitor.trajectory.positions.tolist() == [[1.0, 2.0], [3.0, 4.0]]


def test_no_more_than_the_frequency(states, hear):
    """What comes too early is left out, and what is older than the last."""
    with TrajectoryMonitor(states, ('a',), 10.0) as monitor:
        for seconds in (1.0, 1.05, 1.1, 1.04, 1.15, 1.3):
            hear(seconds, a=seconds)
    assert monitor.trajectory.positions[:, 0].tolist() == [1.0, 1.1, 1.3]


def test_nothing_is_recorded_before_all_joints_are_known(states, hear):
    """Messages that lack some of the joints are left out."""
    with TrajectoryMonitor(states, ('a', 'b'), 10.0) as monitor:
        hear(1.0, a=1.0)
        hear(2.0, a=1.0, b=2.0)
    assert len(monitor.trajectory) == 1


def test_nothing_is_recorded_after_the_end(states, hear):
    """The states of the next motion are left out."""
    with TrajectoryMonitor(states, ('a',), 10.0) as monitor:
        hear(1.0, a=1.0)
    hear(2.0, a=2.0)
    assert len(monitor.trajectory) == 1


def test_a_frequency_of_zero_records_nothing(states, hear):
    """That is the default."""
    with TrajectoryMonitor(states, ('a',), 0.0) as monitor:
        hear(1.0, a=1.0)
    assert len(monitor.trajectory) == 0
    assert states.recorders == []
