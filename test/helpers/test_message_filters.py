# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""message_filters without a ROS graph, as upstream's tests."""

import random

from message_filters import ApproximateTimeSynchronizer, Cache, SimpleFilter, TimeSynchronizer
import pytest
from rclpy.clock import ClockType
from rclpy.time import Time
from sensor_msgs.msg import JointState
from stamped_transforms import at
from std_msgs.msg import String

ROS = ClockType.ROS_TIME


def ros(seconds):
    """Return a time of the clock that stamps have."""
    return Time(seconds=seconds, clock_type=ROS)


def message(seconds, name=''):
    """Return a message with a stamp [s]."""
    result = JointState()
    result.header.stamp = at(seconds).to_msg()
    result.header.frame_id = name
    return result


def test_arguments_of_a_registration_follow_the_message():
    """All registered functions are called."""
    source, heard = SimpleFilter(), []
    for word in 'ab':
        source.registerCallback(lambda *words: heard.append(words), word)
    source.signalMessage(1, 2)
    assert heard == [(1, 2, 'a'), (1, 2, 'b')]


def test_a_cache_answers_by_time():
    """Intervals, neighbours of a time, and the limits."""
    source = SimpleFilter()
    cache = Cache(source, 5)
    assert cache.getLast() is None
    assert cache.getLatestTime() is None
    for seconds in range(8):
        source.signalMessage(message(float(seconds)))

    def times(messages):
        return [each.header.stamp.sec for each in messages]

    assert times(cache.getInterval(ros(2.5), ros(5.0))) == [3, 4, 5]
    assert times([cache.getElemAfterTime(ros(4.5)), cache.getElemBeforeTime(ros(4.5))]) == [5, 4]
    assert cache.getElemBeforeTime(ros(1.0)) is None
    assert times([cache.getLast()]) == [7]
    assert (cache.getOldestTime(), cache.getLastestTime()) == (ros(3.0), ros(7.0))


def test_messages_without_a_header_are_refused_or_taken_now(capfd):
    """The log says how they are taken."""
    source = SimpleFilter()
    refusing, taking = Cache(source), Cache(source, allow_headerless=True)
    source.signalMessage(String(data='x'))
    assert refusing.getLast() is None
    assert 'allow_headerless=True' in capfd.readouterr().err
    assert taking.getLast().data == 'x'


def _synchronizer(kind, count, *args, **kwargs):
    sources, sets = [SimpleFilter() for _ in range(count)], []
    kind(sources, *args, **kwargs).registerCallback(lambda *found: sets.append(found))
    return sources, sets


def test_equal_stamps_make_a_set_in_whatever_order_they_come():
    """Every stamp that all filters had comes out exactly once."""
    sources, sets = _synchronizer(TimeSynchronizer, 3, 20)
    arrivals = [(source, number) for source in range(3) for number in range(20)]
    random.Random(1).shuffle(arrivals)
    for source, number in arrivals:
        sources[source].signalMessage(message(number / 10, str(source)))
    assert sorted(found[0].header.stamp.nanosec + found[0].header.stamp.sec * 10**9
                  for found in sets) == [number * 10**8 for number in range(20)]
    for found in sets:
        assert [each.header.frame_id for each in found] == ['0', '1', '2']
        assert len({each.header.stamp.nanosec for each in found}) == 1


def test_a_full_queue_drops_its_oldest_message():
    """Also where the oldest is the one that has just come."""
    sources, sets = _synchronizer(TimeSynchronizer, 2, 2)
    for seconds in (1.0, 2.0, 3.0):
        sources[0].signalMessage(message(seconds))
    sources[1].signalMessage(message(1.0))
    assert sets == []
    sources[1].signalMessage(message(3.0))
    assert len(sets) == 1


def test_near_stamps_make_a_set():
    """The nearest message counts, and each is used once."""
    sources, sets = _synchronizer(ApproximateTimeSynchronizer, 2, 10, 0.1)
    for seconds in (1.0, 1.06, 1.5):
        sources[0].signalMessage(message(seconds))
    sources[1].signalMessage(message(1.05))
    assert [each.header.stamp.nanosec for each in sets[0]] == [60_000_000, 50_000_000]
    sources[1].signalMessage(message(1.3))
    assert len(sets) == 1
    sources[1].signalMessage(message(1.02))
    assert len(sets) == 2


@pytest.mark.parametrize(('stamps', 'count'), [((1.0, 1.05, 1.09), 1), ((1.0, 1.05, 1.11), 0)])
def test_all_stamps_of_a_set_are_within_the_slop(stamps, count):
    """Not each of them to the newest alone."""
    sources, sets = _synchronizer(ApproximateTimeSynchronizer, 3, 10, 0.1)
    for source, seconds in zip((0, 2, 1), (stamps[0], stamps[2], stamps[1]), strict=True):
        sources[source].signalMessage(message(seconds))
    assert len(sets) == count


def test_the_slop_takes_messages_without_a_header():
    """At the time when they come."""
    sources, sets = _synchronizer(
        ApproximateTimeSynchronizer, 2, 10, 30.0, allow_headerless=True)
    sources[0].signalMessage(String(data='a'))
    sources[1].signalMessage(String(data='b'))
    assert [[each.data for each in found] for found in sets] == [['a', 'b']]
