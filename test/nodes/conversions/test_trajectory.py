# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Trajectories as messages and as values."""

from control_msgs.msg import JointTrajectoryControllerState
import numpy as np
import pytest
from rclpy.serialization import deserialize_message
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMessage
from trajectory_msgs.msg import JointTrajectoryPoint

from armsim_ros.control.trajectory.controller_state import ControllerSnapshot, ROWS
from armsim_ros.nodes.conversions.trajectory import (
    SerializedControllerState,
    trajectory_from_message,
    trajectory_to_message,
)
from armsim_ros.trajectory import JointTrajectory


def test_a_trajectory_goes_there_and_back() -> None:
    """Names, stamp, times and all given fields survive; what was not given is not there."""
    nothing = [np.nan, np.nan]
    trajectory = JointTrajectory(
        ('b', 'a'), np.array([0.5, 1.25]), np.array([[1.0, 2.0], [3.0, 4.0]]),
        np.array([[0.1, 0.2], nothing]), stamp_ns=5_000_000_001,
    )
    message = trajectory_to_message(trajectory)
    assert [len(point.velocities) for point in message.points] == [2, 0]
    back = trajectory_from_message(message)
    assert (back.joint_names, back.stamp_ns, back.fault) == (('b', 'a'), 5_000_000_001, '')
    np.testing.assert_array_equal(back.times, trajectory.times)
    np.testing.assert_array_equal(back.positions, trajectory.positions)
    np.testing.assert_array_equal(back.velocities, trajectory.velocities)
    assert back.accelerations is None
    assert back.effort is None


@pytest.mark.parametrize(('velocities', 'fault'), [
    ([1.0], 'point 1 has 1 velocities for 2 joints; allowed: 2 or none'),
    ([0.0, np.nan], "point 1 has nan among its velocities, for joint 'a'; allowed: finite numb"),
    ([np.nan, np.nan], "point 1 has nan among its velocities, for joint 'b'"),
    ([0.0, np.inf], "point 1 has inf among its velocities, for joint 'a'"),
])
def test_what_makes_no_arrays_is_a_fault(velocities: list[float], fault: str) -> None:
    """Wrong sizes and numbers that are not finite are told, for whoever runs the trajectory."""
    message = JointTrajectoryMessage(joint_names=['b', 'a'], points=[
        JointTrajectoryPoint(positions=[0.0, 0.0]),
        JointTrajectoryPoint(positions=[1.0, 1.0], velocities=velocities)])
    assert trajectory_from_message(message).fault.startswith(fault)


def test_values_do_not_share_memory_with_the_message() -> None:
    """A message may be reused while the trajectory runs."""
    message = trajectory_to_message(JointTrajectory(('a',), np.ones(1), np.ones((1, 1))))
    trajectory = trajectory_from_message(message)
    message.points[0].positions[0] = 9.0
    assert trajectory.positions[0, 0] == 1.0


@pytest.mark.parametrize(('states', 'commands'), [
    (('position',), ('position',)),
    (('position', 'velocity'), ('effort',)),
    (('position', 'velocity', 'acceleration'), ('velocity', 'position')),
])
def test_controller_state_has_what_the_snapshot_has(states, commands) -> None:
    """Each number is in its field, also before a trajectory begins; other fields are empty."""
    data = np.random.default_rng(1).normal(size=(ROWS, 3))
    first = ControllerSnapshot(
        5_000_000_001, ('b', 'a', 'c'), data, states, commands, 1.5, 2.25, 0.5, 1)
    serialized = SerializedControllerState(first)
    later = ControllerSnapshot(
        6_000_000_002, first.joint_names, data + 1.0, states, commands, -0.25, 0.0, 1.0, 2)
    for snapshot in (first, later):
        message = deserialize_message(serialized.of(snapshot), JointTrajectoryControllerState)
        stamp = message.header.stamp
        assert stamp.sec * 1_000_000_000 + stamp.nanosec == snapshot.time_ns
        assert message.joint_names == ['b', 'a', 'c']
        assert message.speed_scaling_factor == snapshot.speed_scaling_factor
        for name, seconds in (
            ('reference', snapshot.desired_time_from_start),
            ('feedback', snapshot.actual_time_from_start),
            ('error', snapshot.actual_time_from_start),
            ('output', snapshot.desired_time_from_start),
        ):
            sent, value = getattr(message, name), getattr(snapshot, name)
            time = sent.time_from_start
            assert time.sec + time.nanosec * 1e-9 == seconds
            for field in ('positions', 'velocities', 'accelerations', 'effort'):
                np.testing.assert_array_equal(getattr(sent, field), getattr(value, field))


def test_controller_state_of_other_joints_or_interfaces_does_not_fit() -> None:
    """A controller that was configured anew gets a message of its own."""
    def snapshot(names: tuple[str, ...], commands: tuple[str, ...]) -> ControllerSnapshot:
        data = np.zeros((ROWS, len(names)))
        return ControllerSnapshot(0, names, data, ('position',), commands, 0.0, 0.0, 1.0, 0)

    serialized = SerializedControllerState(snapshot(('a', 'b'), ('position',)))
    assert serialized.fits(snapshot(('a', 'b'), ('position',)))
    assert not serialized.fits(snapshot(('b', 'a'), ('position',)))
    assert not serialized.fits(snapshot(('a', 'b'), ('velocity',)))
