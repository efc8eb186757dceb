# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Texts that are published once, also for late subscribers."""

from __future__ import annotations

from rclpy.node import Node
from rclpy.publisher import Publisher
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
