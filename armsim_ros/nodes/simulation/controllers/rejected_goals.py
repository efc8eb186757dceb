# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``~/rejected_goals``."""

from __future__ import annotations

from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import String

from armsim_ros.nodes import qos


class RejectedGoals:
    """
    Publishes why a goal or trajectory was refused; an action's rejection has no room for it.

    :param node: the controller's node.
    :param profile: how long a reason is there for late subscribers, among others.
    """

    def __init__(self, node: Node, profile: QoSProfile = qos.EVENTS) -> None:
        self._publisher = node.create_publisher(String, '~/rejected_goals', profile)

    def publish(self, reason: str) -> None:
        """Publish a reason."""
        self._publisher.publish(String(data=reason))
