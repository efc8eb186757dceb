# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The message of a ball in the world."""

from moveit_msgs.msg import CollisionObject
from shape_msgs.msg import SolidPrimitive


def ball_message(frame, name, point, radius=0.1):
    """Return the message that adds a ball at a point (3,) [m] of a frame."""
    message = CollisionObject(id=name, operation=CollisionObject.ADD)
    message.header.frame_id = frame
    message.primitives = [SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[radius])]
    message.pose.orientation.w = 1.0
    place = message.pose.position
    place.x, place.y, place.z = map(float, point)
    return message
