# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Publishing of static frames."""

from __future__ import annotations

from collections.abc import Iterable

from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from tf2_msgs.msg import TFMessage

from tf2_ros.transform_broadcaster import as_list


class StaticTransformBroadcaster:
    """
    Publishes transforms on /tf_static, where late subscribers get them too.

    :param qos: a profile or a depth (default: reliable, transient local, 1).
    """

    def __init__(self, node: Node, qos: QoSProfile | int | None = None) -> None:
        if qos is None:
            qos = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.pub_tf = node.create_publisher(TFMessage, '/tf_static', qos)
        self._transforms: dict[str, TransformStamped] = {}

    def sendTransform(self, transform: TransformStamped | Iterable[TransformStamped]) -> None:
        """Publish a transform, or several, with all sent before; the newest of a child counts."""
        self._transforms.update({each.child_frame_id: each for each in as_list(transform)})
        self.pub_tf.publish(TFMessage(transforms=list(self._transforms.values())))
