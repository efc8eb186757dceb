# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``/robot_description``."""

from __future__ import annotations

from rclpy.node import Node
from rclpy.publisher import Publisher
from std_msgs.msg import String

from armsim_ros.nodes import qos


def publish_robot_description(node: Node, urdf: str) -> Publisher:
    """
    Publish the URDF once, for all who come later too.

    :param node: the node that publishes.
    :param urdf: the text after xacro.
    :returns: the publisher, which must be kept alive.
    """
    return publish_text(node, 'robot_description', urdf)


def publish_text(node: Node, topic: str, text: str) -> Publisher:
    """Publish a latched text; the publisher that is returned must be kept alive."""
    publisher = node.create_publisher(String, topic, qos.LATCHED)
    publisher.publish(String(data=text))
    return publisher
