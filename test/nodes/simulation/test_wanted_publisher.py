# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When a message of a frequent topic is worth making, and for whom."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from std_msgs.msg import String

from armsim_ros.nodes import qos
from armsim_ros.nodes.qos import CalmSubscribers, GRAPH_PERIOD_NS, RENEWAL_NS, WantedPublisher


class Node:
    """Stands for a node and for its publisher."""

    topic_name = '/joint_states'

    def __init__(self) -> None:
        self.readers = 0
        self.known: list[str] = []
        self.searches = 0

    def create_publisher(self, _kind: object, _topic: str, _profile: object) -> Node:
        return self

    def get_subscription_count(self) -> int:
        return self.readers

    def get_subscriptions_info_by_topic(self, topic: str) -> list[SimpleNamespace]:
        assert topic == self.topic_name
        self.searches += 1
        return [SimpleNamespace(node_name=name) for name in self.known]

    def publish(self, message: object) -> None:
        """Do nothing."""


@pytest.fixture
def node() -> Node:
    """Give a node without readers."""
    return Node()


def test_every_message_is_wanted_by_a_reader(node: Node) -> None:
    """At whatever rate it comes."""
    publisher = WantedPublisher(node, String, 'topic', qos.STATE)
    node.readers = 1
    for time_ns in range(5):
        assert publisher.wanted(time_ns)
        publisher.publish(String(), time_ns)


def test_nobody_wants_a_volatile_message(node: Node) -> None:
    """Who comes later does not get it either."""
    assert not WantedPublisher(node, String, 'topic', qos.CLOCK).wanted(0)


def test_a_latched_message_is_renewed_for_those_who_come_late(node: Node) -> None:
    """At once, then ten times a second, and after a jump of time."""
    publisher = WantedPublisher(node, String, 'topic', qos.STATE)
    assert publisher.wanted(RENEWAL_NS)
    publisher.publish(String(), RENEWAL_NS)
    assert not publisher.wanted(2 * RENEWAL_NS - 1)
    assert publisher.wanted(2 * RENEWAL_NS)
    assert publisher.wanted(0)


def test_only_programs_of_this_package_are_calm(node: Node) -> None:
    """Another subscriber is noticed at once by the number of subscribers, and forgotten so."""
    calm = CalmSubscribers(node, node)
    results = []
    for names in ([], ['move_group'], ['move_group', 'rviz'], ['servo_node']):
        node.known, node.readers = names, len(names)
        results.append(calm(len(results)))
    assert results == [True, True, False, True]


def test_a_subscriber_that_the_graph_does_not_know_yet_is_not_calm(node: Node) -> None:
    """It is searched for again after a while, not for every message."""
    calm, (node.readers, node.known) = CalmSubscribers(node, node), (1, [])
    assert not calm(0)
    node.known = ['move_group']
    assert not calm(GRAPH_PERIOD_NS - 1)
    assert calm(GRAPH_PERIOD_NS)
    assert node.searches == 2
