# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Subscribes to the camera's colour and depth, and prints a line for each pair of pictures."""

from __future__ import annotations

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import Image

PICTURE = 'picture'


def listen() -> None:
    """Listen until a signal comes."""
    rclpy.init()
    node = Node('picture_listener')
    seen: set[tuple[int, int]] = set()

    def receive(message: Image) -> None:
        stamp = message.header.stamp.sec, message.header.stamp.nanosec
        if stamp in seen:
            seen.remove(stamp)
            print(PICTURE, flush=True)
        else:
            seen.add(stamp)

    for kind in ('color', 'depth'):
        node.create_subscription(Image, f'/camera/{kind}/image_raw', receive, 2)
    try:
        rclpy.spin(node)
    except ExternalShutdownException:
        return


if __name__ == '__main__':
    listen()
