# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Messages that are serialized once and changed in place."""

from array import array

from geometry_msgs.msg import PoseStamped, TwistStamped, Vector3
import numpy as np
import pytest
from rclpy.serialization import deserialize_message
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from armsim_ros.nodes.conversions.serialized import SerializedMessage
from armsim_ros.nodes.conversions.time import ns_from_time, time_from_ns

NOW_NS = 1_700_000_000_123_456_789


@pytest.mark.parametrize('frame', ['', 'a', 'link', 'world/frame'])
def test_it_is_what_the_middleware_would_send(frame: str) -> None:
    """Whatever stands before them, stamp and numbers are where they belong."""
    message = PoseStamped()
    message.header.frame_id = frame
    position = message.pose.position
    message.pose.orientation.w = 0.5
    serialized = SerializedMessage(
        message, [message.header.stamp], [(position, 'x'), (position, 'y'), (position, 'z')])
    for time_ns, xyz in ((0, (1.0, -2.0, 0.0)), (NOW_NS, (np.nan, np.inf, 1e-300))):
        serialized.set_numbers(np.array(xyz))
        position.x, position.y, position.z = xyz
        message.header.stamp = time_from_ns(time_ns)
        sent = deserialize_message(serialized.at(time_ns), PoseStamped)
        assert repr(sent) == repr(message)  # NaN is not equal to itself


def test_arrays_and_durations() -> None:
    """Whole arrays and durations change as well, each in its own place."""
    points = [JointTrajectoryPoint(positions=array('d', [0.0] * 3)) for _ in range(2)]
    message = JointTrajectory(joint_names=['a', 'bc', 'd'], points=points)
    serialized = SerializedMessage(
        message, [message.header.stamp], [(point, 'positions') for point in points],
        [point.time_from_start for point in points],
    )
    values, spans = np.arange(6.0), np.array([1, 12_345_678_901])
    serialized.set_numbers(values)
    serialized.set_durations(spans)
    sent = deserialize_message(serialized.at(NOW_NS), JointTrajectory)
    assert ns_from_time(sent.header.stamp) == NOW_NS
    told = np.concatenate([point.positions for point in sent.points])
    np.testing.assert_array_equal(told, values)
    assert [ns_from_time(point.time_from_start) for point in sent.points] == spans.tolist()


def test_what_was_sent_before_stays_as_it_was() -> None:
    """The middleware may hold on to it while the next one is made."""
    message = TwistStamped()
    serialized = SerializedMessage(message, [message.header.stamp], [(message.twist.linear, 'x')])
    serialized.set_numbers(np.array([1.0]))
    first = serialized.at(1)
    serialized.set_numbers(np.array([2.0]))
    assert serialized.at(2) != first
    assert deserialize_message(first, TwistStamped).twist.linear == Vector3(x=1.0)


def test_a_field_that_is_not_sent_is_told() -> None:
    """A stamp that is not of the message is not looked for in vain."""
    message, other = PoseStamped(), PoseStamped()
    with pytest.raises(ValueError, match='2 equal fields'):
        SerializedMessage(message, [message.header.stamp, other.header.stamp], [])


def test_messages_of_many_lengths_one_after_the_other():
    """What the middleware leaves behind a message, of earlier ones, is not part of it."""
    for count in range(1, 60):
        numbers = array('d', [0.0] * 6)
        points = [JointTrajectoryPoint(positions=numbers, velocities=numbers)
                  for _ in range(count)]
        message = JointTrajectory(joint_names=list('abcdef'), points=points)
        serialized = SerializedMessage(
            message, [message.header.stamp],
            [(point, name) for point in points for name in ('positions', 'velocities')],
            [point.time_from_start for point in points])
        serialized.set_numbers(np.arange(12.0 * count))
        serialized.set_durations(np.arange(count) * 10_000_000)
        found = deserialize_message(serialized.at(5_000_000_007), JointTrajectory)
        assert (found.header.stamp.sec, found.header.stamp.nanosec) == (5, 7)
        assert np.hstack([[*point.positions, *point.velocities] for point in found.points]
                         ).tolist() == list(range(12 * count))
        assert [point.time_from_start.nanosec for point in found.points] == [
            10_000_000 * (k % 100) for k in range(count)]
