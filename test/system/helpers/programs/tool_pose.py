# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A user's program: prints where the tool is, as its listener sees it."""

import sys

import rclpy
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.time import Time
from tf2_ros import Buffer, TransformListener

rclpy.init()
node = Node('tool_pose')
buffer = Buffer()
TransformListener(buffer, node, spin_thread=True)
found = buffer.lookup_transform(*sys.argv[1:3], Time(), Duration(seconds=60)).transform
print(found.translation.x, found.translation.y, found.translation.z, found.rotation.x,
      found.rotation.y, found.rotation.z, found.rotation.w)
rclpy.shutdown()
assert 'armsim_ros' not in sys.modules
