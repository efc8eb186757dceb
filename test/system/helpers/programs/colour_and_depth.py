# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A user's program: takes a colour image and the depth image of the same moment."""

import sys

from cv_bridge import CvBridge
from message_filters import ApproximateTimeSynchronizer, Subscriber
import rclpy
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import Image


def show(colour_message, depth_message):
    """Print sizes, the difference of the stamps [ns] and the nearest distance [m]."""
    colour = bridge.imgmsg_to_cv2(colour_message, 'bgr8')
    depth = bridge.imgmsg_to_cv2(depth_message, '32FC1')
    apart = colour_message.header.stamp.nanosec - depth_message.header.stamp.nanosec
    print(*colour.shape, *depth.shape, apart, depth[depth > 0].min())
    rclpy.shutdown()


rclpy.init()
node, bridge = Node('colour_and_depth'), CvBridge()
topics = [Subscriber(node, Image, f'/camera/{name}/image_raw', qos_profile=qos_profile_sensor_data)
          for name in ('color', 'depth')]
synchronizer = ApproximateTimeSynchronizer(topics, 5, 0.01)
synchronizer.registerCallback(show)
while rclpy.ok():
    rclpy.spin_once(node)
assert 'armsim_ros' not in sys.modules
