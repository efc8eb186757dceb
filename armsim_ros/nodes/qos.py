# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Quality-of-service profiles of every endpoint, and publishers of rare or frequent topics.

A publisher offers as much as it can (reliable, and the last value kept where it is a state), a
subscription asks for as little as it can, so that any client's choice matches. What Fast DDS
makes of the "system default" profile was measured: reliable and transient-local for a
publisher, best effort, volatile and of depth 1 for a subscription.
"""

from __future__ import annotations

from typing import Any

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSDurabilityPolicy, QoSHistoryPolicy, QoSProfile, QoSReliabilityPolicy
from std_msgs.msg import String

from armsim_ros.nodes import qos


def _profile(
    reliability: QoSReliabilityPolicy, durability: QoSDurabilityPolicy, depth: int,
    history: QoSHistoryPolicy = QoSHistoryPolicy.KEEP_LAST, **more: Duration
) -> QoSProfile:
    return QoSProfile(
        reliability=reliability, durability=durability, depth=depth, history=history, **more)


STATE = _profile(QoSReliabilityPolicy.RELIABLE, QoSDurabilityPolicy.TRANSIENT_LOCAL, 1)
"""Publishers of a state that is renewed all the time: joint_states, controller_state."""

LATCHED = _profile(QoSReliabilityPolicy.RELIABLE, QoSDurabilityPolicy.TRANSIENT_LOCAL, 1)
"""Publishers of a text or state that late subscribers must get: robot_description, tf_static."""

EVENTS = _profile(
    QoSReliabilityPolicy.RELIABLE, QoSDurabilityPolicy.TRANSIENT_LOCAL, 1,
    lifespan=Duration(seconds=10))
"""
Publishers of rare events, the last of which matters for a while to late subscribers:
rejected_goals.
"""

CLOCK = _profile(QoSReliabilityPolicy.RELIABLE, QoSDurabilityPolicy.VOLATILE, 1)
"""Publisher of /clock; the subscription of rclcpp and rclpy is best effort, depth 1."""

TF = _profile(QoSReliabilityPolicy.RELIABLE, QoSDurabilityPolicy.VOLATILE, 100)
"""Publisher of /tf, as tf2_ros has it."""

DIAGNOSTICS = _profile(QoSReliabilityPolicy.RELIABLE, QoSDurabilityPolicy.VOLATILE, 10)
"""Publisher of /diagnostics, as diagnostic_updater has it."""

PICTURES = _profile(QoSReliabilityPolicy.RELIABLE, QoSDurabilityPolicy.VOLATILE, 2)
"""Publishers of camera pictures and of what belongs to them."""

COMMAND = _profile(QoSReliabilityPolicy.BEST_EFFORT, QoSDurabilityPolicy.VOLATILE, 1)
"""
Subscriptions to commands: match every publisher, and only the newest message counts, as with
upstream's "system default".
"""

SERVICES = _profile(
    QoSReliabilityPolicy.RELIABLE, QoSDurabilityPolicy.VOLATILE, 0, QoSHistoryPolicy.KEEP_ALL)
"""Services: a burst of requests loses none."""

ACTION_SERVICES = dict.fromkeys(
    ('goal_service_qos_profile', 'result_service_qos_profile', 'cancel_service_qos_profile'),
    SERVICES)
"""Arguments of an action server, for the same."""

DESCRIPTION = _profile(QoSReliabilityPolicy.RELIABLE, QoSDurabilityPolicy.TRANSIENT_LOCAL, 1)
"""Subscriptions to a latched text."""


def publish_text(node: Node, topic: str, text: str) -> Publisher | None:
    """
    Publish a latched text.

    :returns: the publisher, which must be kept alive; None where there is no text.
    """
    if not text:
        return None
    publisher = node.create_publisher(String, topic, qos.LATCHED)
    publisher.publish(String(data=text))
    return publisher


def publish_descriptions(node: Node, urdf: str, srdf: str) -> list[Publisher | None]:
    """
    Publish ``robot_description`` and ``robot_description_semantic``.

    A robot without SRDF leaves that topic to others: its planner may publish it.

    :returns: the publishers, which must be kept alive.
    """
    return [publish_text(node, 'robot_description', urdf),
            publish_text(node, 'robot_description_semantic', srdf)]


#: A latched state without subscribers is still renewed this often, for late subscribers [ns].
RENEWAL_NS = 100_000_000


class WantedPublisher:
    """
    A publisher of a topic that comes often.

    To compose and send a message costs ten times as much as to count subscribers. A message
    without subscribers is not composed; where late subscribers get the last message, as with the
    state of a controller, it is renewed now and then.

    :param kind: the message type.
    """

    def __init__(self, node: Node, kind: type[Any], topic: str, profile: QoSProfile) -> None:
        self._publisher = node.create_publisher(kind, topic, profile)
        self._latched = profile.durability == QoSDurabilityPolicy.TRANSIENT_LOCAL
        self._published_ns: int | None = None

    def wanted(self, time_ns: int) -> bool:
        """Return whether a message is needed now."""
        if self.count:
            return True
        if not self._latched:
            return False
        last = self._published_ns
        return last is None or not 0 <= time_ns - last < RENEWAL_NS

    @property
    def count(self) -> int:
        """Number of subscribers."""
        return int(self._publisher.get_subscription_count())

    def publish(self, message: Any, time_ns: int) -> None:
        """Publish a message of a time [ns]."""
        self._published_ns = time_ns
        self._publisher.publish(message)


#: Programs of this package that read joint states when they need them, by their nodes.
CALM_NODES = frozenset(('move_group', 'servo_node'))
#: The graph is searched for subscribers when their number changes, and this often [ns].
GRAPH_PERIOD_NS = 1_000_000_000


class CalmSubscribers:
    """
    Whether all subscribers of a topic read it when they need it.

    A program that reads states now and then is content with fewer messages while nothing moves.

    :param publisher: its publisher of the topic.
    """

    def __init__(self, node: Node, publisher: Publisher) -> None:
        self._node, self._publisher = node, publisher
        self._count = -1
        self._searched_ns = 0
        self._calm = False

    def __call__(self, time_ns: int) -> bool:
        """Return whether there are no others."""
        count = self._publisher.get_subscription_count()
        if count != self._count or not 0 <= time_ns - self._searched_ns < GRAPH_PERIOD_NS:
            self._count, self._searched_ns = count, time_ns
            known = self._node.get_subscriptions_info_by_topic(self._publisher.topic_name)
            # Of a subscriber that was just matched the graph may know nothing yet.
            self._calm = len(known) >= count and all(
                each.node_name in CALM_NODES for each in known)
        return self._calm
