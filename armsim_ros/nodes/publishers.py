# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Publishers of latched texts, and of frequent topics without unread messages."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from std_msgs.msg import String

from armsim_ros.nodes import qos


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

    :param node: the node that publishes.
    :param kind: the message type.
    """

    def __init__(self, node: Node, kind: type[Any], topic: str, profile: QoSProfile) -> None:
        self._publisher = node.create_publisher(kind, topic, profile)
        self._latched = profile.durability == QoSDurabilityPolicy.TRANSIENT_LOCAL
        self._published_ns: int | None = None

    def wanted(self, time_ns: int) -> bool:
        """
        Return whether a message is needed now.

        :param time_ns: [ns] of the simulation.
        """
        if self._publisher.get_subscription_count():
            return True
        if not self._latched:
            return False
        last = self._published_ns
        return last is None or not 0 <= time_ns - last < RENEWAL_NS

    def publish(self, message: Any, time_ns: int) -> None:
        """Publish a message of a time [ns]."""
        self._published_ns = time_ns
        self._publisher.publish(message)
