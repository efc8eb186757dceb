# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Messages that the tests of tf2 put into buffers."""

from geometry_msgs.msg import TransformStamped
from rclpy.time import Time


def stamped(parent, child, seconds=0.0, translation=(0.0, 0.0, 0.0),
            rotation=(0.0, 0.0, 0.0, 1.0)):
    """Return a transform; the time in [s], or in [ns] where it is an integer."""
    message = TransformStamped()
    message.header.frame_id = parent
    message.child_frame_id = child
    message.header.stamp = at(seconds).to_msg()
    vector, quaternion = message.transform.translation, message.transform.rotation
    vector.x, vector.y, vector.z = map(float, translation)
    quaternion.x, quaternion.y, quaternion.z, quaternion.w = map(float, rotation)
    return message


def at(seconds):
    """Return a time from [s], or from [ns] where it is an integer."""
    return Time(nanoseconds=seconds if isinstance(seconds, int) else round(seconds * 1e9))


def numbers(message):
    """Return translation and rotation of a stamped transform."""
    vector, quaternion = message.transform.translation, message.transform.rotation
    return (vector.x, vector.y, vector.z), (
        quaternion.x, quaternion.y, quaternion.z, quaternion.w)
