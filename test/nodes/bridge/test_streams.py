# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a stream passes on and keeps of the messages of several publishers."""

import pytest
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from std_msgs.msg import String

from armsim_ros.nodes.bridge.topic_reader import Received
from armsim_ros.nodes.bridge.topics import Stream

VOLATILE = QoSProfile(depth=1)
LATCHED = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)


class Reader:
    """A listener that keeps what it is offered."""

    def __init__(self):
        self.texts = []

    def offer(self, sample, _):
        """Keep the message."""
        self.texts.append(sample.raw)


@pytest.fixture
def reader():
    """Return a listener."""
    return Reader()


@pytest.fixture
def stream(reader):
    """Return a stream that has the listener."""
    stream = Stream('/topic', 'std_msgs/msg/String', String, VOLATILE)
    stream.listeners[reader] = None
    return stream


@pytest.fixture
def receive(stream):
    """Return a function that lets the stream receive a publisher's message."""
    return lambda publisher, number: stream.offer(
        Received(f'{publisher}{number}', publisher.encode(), number), (0, 0), 0.0)


@pytest.fixture
def late(stream):
    """Return a function that returns what a late listener gets at once."""
    def late():
        reader = Reader()
        stream.offer_latched(reader, 0.0)
        return reader.texts

    return late


def test_what_a_new_subscription_receives_again_is_dropped(stream, reader, receive, late):
    """Of each publisher; what it receives for the first time is passed on, and all is latched."""
    for publisher, number in (('a', 1), ('b', 1), ('a', 2)):
        receive(publisher, number)
    stream.renew(LATCHED)
    for publisher, number in (('a', 1), ('a', 2), ('a', 3), ('b', 1)):
        receive(publisher, number)
    assert reader.texts == ['a1', 'b1', 'a2', 'a3']
    assert late() == ['a3', 'b1']


def test_a_middleware_without_numbers_loses_nothing(reader, receive):
    """RMW_MESSAGE_INFO_SEQUENCE_NUMBER_UNSUPPORTED says nothing about the order."""
    unsupported = 2**64 - 1
    for _ in range(2):
        receive('a', unsupported)
    assert reader.texts == [f'a{unsupported}'] * 2


def test_a_late_listener_gets_the_newest_message_of_each_publisher(stream, receive, late):
    """However many another has published since, as with /tf_static."""
    stream.renew(LATCHED)
    for publisher, number in (('robot', 1), ('camera', 1), ('camera', 2)):
        receive(publisher, number)
    assert late() == ['robot1', 'camera2']


def test_a_publisher_that_stays_away_is_forgotten(stream, receive, late):
    """The graph may miss it once, while it is being discovered."""
    stream.renew(LATCHED)
    receive('gone', 1)
    receive('new', 1)
    for publishers in (set(), {b'new'}):
        assert late() == ['gone1', 'new1']
        stream.publications.forget_others(publishers)
    assert late() == ['new1']


def test_nothing_is_latched_once_a_publisher_is_volatile(stream, receive, late):
    """A subscription that matches all of them gets no history."""
    stream.renew(LATCHED)
    receive('a', 1)
    stream.renew(VOLATILE)
    assert late() == []
