# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A user's program: turns a depth image into points and compares with the camera's own cloud."""

import sys

from cv_bridge import CvBridge
from message_filters import Subscriber, TimeSynchronizer
import numpy as np
import rclpy
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import CameraInfo, Image, PointCloud2
from sensor_msgs_py import point_cloud2


def compare(depth_message, info, cloud_message):
    """Print how many points there are and by how much they differ at most [m]."""
    depth = CvBridge().imgmsg_to_cv2(depth_message)
    row, column = np.indices(depth.shape)
    points = np.stack([(column - info.k[2]) * depth / info.k[0],
                       (row - info.k[5]) * depth / info.k[4], depth], axis=-1).reshape(-1, 3)
    points = points[np.isfinite(depth).ravel()]
    cloud = point_cloud2.create_cloud_xyz32(depth_message.header, points)
    mine = point_cloud2.read_points_numpy(cloud, skip_nans=True)
    given = point_cloud2.read_points_numpy(cloud_message, ['x', 'y', 'z'], skip_nans=True)
    print(len(mine), len(given), np.abs(mine - given).max())
    rclpy.shutdown()


rclpy.init()
node = Node('depth_to_points')
topics = [Subscriber(node, kind, f'/camera/depth/{name}', qos_profile=qos_profile_sensor_data)
          for kind, name in ((Image, 'image_raw'), (CameraInfo, 'camera_info'),
                             (PointCloud2, 'points'))]
synchronizer = TimeSynchronizer(topics, 10)
synchronizer.registerCallback(compare)
while rclpy.ok():
    rclpy.spin_once(node)
assert 'armsim_ros' not in sys.modules

