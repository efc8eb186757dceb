# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A publisher beside the bridge, or a bare subscriber to compare with."""

from __future__ import annotations

import itertools
import sys
import time

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import Image, JointState, PointCloud2

#: Kind -> topic, type, rate [Hz].
STREAMS = {
    'joints': ('/joint_states', JointState, 50.0),
    'fast': ('/fast', JointState, 1000.0),
    'picture': ('/picture', Image, 30.0),
    'cloud': ('/cloud', PointCloud2, 0.25),
}


def message_of(kind: str) -> JointState | Image | PointCloud2:
    """Return a message of usual size; a cloud is large."""
    if kind == 'cloud':
        return PointCloud2(data=bytes(50_000_000))
    if kind == 'picture':
        return Image(height=480, width=640, step=1920, encoding='rgb8', data=bytes(480 * 1920))
    names = [f'joint_{index}' for index in range(6)]
    return JointState(name=names, position=[0.1] * 6, velocity=[0.2] * 6, effort=[0.3] * 6)


def publish(node: Node, kind: str) -> None:
    """Publish a stream; the stamp is the time of sending, the frame a number that counts up."""
    topic, message_type, rate = STREAMS[kind]
    publisher = node.create_publisher(message_type, topic, 10)
    message = message_of(kind)
    numbers = itertools.count()

    def send() -> None:
        now = time.time_ns()
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(now, 10**9)
        message.header.frame_id = str(next(numbers))
        publisher.publish(message)

    node.create_timer(1.0 / rate, send)


def main() -> None:
    """Run as named by the arguments: publish or subscribe, and a stream."""
    role, kind, *raw = sys.argv[1:]
    rclpy.init()
    node = Node(f'bench_{role}')
    if role == 'publish':
        publish(node, kind)
    else:
        topic, message_type, _ = STREAMS[kind]
        node.create_subscription(message_type, topic, lambda _: None, 10, raw=bool(raw))
    print('ready', flush=True)
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        return


if __name__ == '__main__':
    main()
