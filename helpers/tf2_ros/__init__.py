# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Transforms between frames over ROS 2: the interface of tf2_ros for Python.

Programs also import message types and times from here, because upstream exports them.
"""

from geometry_msgs.msg import (
    PointStamped,
    PoseStamped,
    PoseWithCovarianceStamped,
    TransformStamped,
    Vector3Stamped,
)
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.time import Time
from tf2_msgs.msg import TFMessage
from tf2_py import (
    BufferCore,
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TimeoutException,
    TransformException,
)

from tf2_ros.buffer import Buffer
from tf2_ros.buffer_interface import (
    BufferInterface,
    convert,
    ConvertRegistration,
    NotImplementedException,
    Stamped,
    TransformRegistration,
    TypeException,
)
from tf2_ros.static_transform_broadcaster import StaticTransformBroadcaster
from tf2_ros.transform_broadcaster import TransformBroadcaster
from tf2_ros.transform_listener import TransformListener

__all__ = [
    'Buffer',
    'BufferCore',
    'BufferInterface',
    'ConnectivityException',
    'ConvertRegistration',
    'Duration',
    'ExtrapolationException',
    'InvalidArgumentException',
    'LookupException',
    'Node',
    'NotImplementedException',
    'PointStamped',
    'PoseStamped',
    'PoseWithCovarianceStamped',
    'Stamped',
    'StaticTransformBroadcaster',
    'TFMessage',
    'Time',
    'TimeoutException',
    'TransformBroadcaster',
    'TransformException',
    'TransformListener',
    'TransformRegistration',
    'TransformStamped',
    'TypeException',
    'Vector3Stamped',
    'convert',
]
