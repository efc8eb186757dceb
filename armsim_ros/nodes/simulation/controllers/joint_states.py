# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``joint_states``."""

from __future__ import annotations

from rclpy.node import Node
from sensor_msgs.msg import JointState

from armsim_ros.control.broadcasters.joint_state_broadcaster import JointStateSnapshot
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.joint_state import JointStateBuffer


class JointStates:
    """
    Publishes what the joint state broadcaster has sampled.

    :param node: the broadcaster's node; the topic lies in its namespace.
    :param local: publish under the node's name instead.
    """

    def __init__(self, node: Node, *, local: bool = False) -> None:
        topic = '~/joint_states' if local else 'joint_states'
        self._publisher = node.create_publisher(JointState, topic, qos.STATE)
        self._names: tuple[str, ...] = ()
        self._buffer = JointStateBuffer(())

    def publish(self, sample: JointStateSnapshot) -> None:
        """Publish a sample."""
        if sample.names != self._names:
            self._names = sample.names
            self._buffer = JointStateBuffer(sample.names, sample.frame_id)
        self._publisher.publish(
            self._buffer.fill(sample.time_ns, sample.position, sample.velocity, sample.effort)
        )
