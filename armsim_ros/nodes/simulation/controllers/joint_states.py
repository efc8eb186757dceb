# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topics ``joint_states`` and ``dynamic_joint_states``."""

from __future__ import annotations

from control_msgs.msg import DynamicJointState
from rclpy.node import Node
from sensor_msgs.msg import JointState

from armsim_ros.control.broadcasters.joint_state_broadcaster import JointStateSnapshot
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.joint_state import DynamicJointStateBuffer, JointStateBuffer
from armsim_ros.nodes.simulation.wanted_publisher import WantedPublisher


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


class DynamicJointStates:
    """
    Publishes every state interface that the joint state broadcaster has sampled.

    :param node: the broadcaster's node; the topic lies in its namespace.
    :param local: publish under the node's name instead.
    """

    def __init__(self, node: Node, *, local: bool = False) -> None:
        topic = '~/dynamic_joint_states' if local else 'dynamic_joint_states'
        self._publisher = WantedPublisher(node, DynamicJointState, topic, qos.STATE)
        self._interfaces: dict[str, tuple[str, ...]] = {}
        self._buffer = DynamicJointStateBuffer({})

    def publish(self, sample: JointStateSnapshot) -> None:
        """Publish a sample."""
        if not self._publisher.wanted(sample.time_ns):
            return
        dynamic = sample.dynamic
        interfaces = {joint: names for joint, names, _ in dynamic}
        if interfaces != self._interfaces:
            self._interfaces = interfaces
            self._buffer = DynamicJointStateBuffer(interfaces, sample.frame_id)
        values = [numbers for _, _, numbers in dynamic]
        self._publisher.publish(self._buffer.fill(sample.time_ns, values), sample.time_ns)
