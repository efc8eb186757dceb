# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A driver of a depth camera: ``python -m benchmarks.perception.cloud_publisher TOPIC FRAME RATE``.

Publishes the same 640 x 480 points each time, and prints a line for each cloud.
"""

from __future__ import annotations

from contextlib import suppress
import sys
import time

import numpy as np
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import PointCloud2

from armsim_ros.nodes.conversions.measurements import cloud_of_points
from benchmarks.perception.octomap import table

PUBLISHED = 'cloud'
#: The camera is on the arm, and what it sees moves with it: no motion is to be blocked [m].
BEYOND_REACH = np.array((0.0, 0.0, 1.0), dtype=np.float32)


def main(topic: str, frame: str, rate: str) -> None:
    """Publish until a signal comes."""
    rclpy.init()
    node = rclpy.create_node('cloud_publisher')
    publisher = node.create_publisher(PointCloud2, topic, qos_profile_sensor_data)
    cloud = cloud_of_points(table()[0] + BEYOND_REACH, PointCloud2())
    cloud.header.frame_id = frame

    def publish() -> None:
        now_ns = time.time_ns()
        cloud.header.stamp.sec, cloud.header.stamp.nanosec = divmod(now_ns, 10**9)
        publisher.publish(cloud)
        print(PUBLISHED, flush=True)

    node.create_timer(1.0 / float(rate), publish)
    with suppress(ExternalShutdownException):
        rclpy.spin(node)


if __name__ == '__main__':
    main(*sys.argv[1:])
