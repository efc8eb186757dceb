# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``~/status``."""

from __future__ import annotations

from moveit_msgs.msg import ServoStatus as ServoStatusMessage
from rclpy.serialization import serialize_message

from armsim_ros.nodes import qos
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.servo.status import Finding


class StatusTopic:
    """Publishes the result of each cycle."""

    def __init__(self, node: PollingNode, topic: str) -> None:
        self._publisher = node.create_publisher(ServoStatusMessage, topic, qos.STATE)
        self._finding: Finding | None = None
        self._serialized = b''

    @property
    def heard(self) -> bool:
        """Whether there are subscribers."""
        return self._publisher.get_subscription_count() > 0

    def publish(self, finding: Finding) -> None:
        """Publish a finding; late subscribers get the last."""
        if finding != self._finding:
            self._finding = finding
            self._serialized = serialize_message(
                ServoStatusMessage(code=int(finding.code), message=finding.message))
        self._publisher.publish(self._serialized)
