# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Frames of the planning scene's objects on ``/tf``: the capability TfPublisher."""

from __future__ import annotations

from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import TransformStamped
from rclpy.clock import Clock, ClockType
from tf2_msgs.msg import TFMessage

from armsim_ros.arrays import Matrix
from armsim_ros.model.transforms import quat_xyzw_from_matrix
from armsim_ros.nodes import qos
from armsim_ros.nodes.move_group.context import Context

RATE, PREFIX = 'planning_scene_frame_publishing_rate', 'planning_scene_tf_prefix'


class SceneFrames:
    """
    Publishes the frames of objects and their subframes, attached ones included.

    The frame of an object is ``<prefix>/<object>``; that of a subframe,
    ``<prefix>/<object>/<subframe>``, is its child. The prefix is a parameter, by default the
    node's name; '' is none. Each message holds a single transform.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        node = context.node
        rate = float(_parameter(context, RATE, 10))
        prefix = str(_parameter(context, PREFIX, node.get_name()))
        self._prefix = f'{prefix}/' if prefix else ''
        self._publisher = node.create_publisher(TFMessage, '/tf', qos.TF)
        self._timer = node.create_timer(
            1.0 / max(rate, 0.1), self._publish, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )

    def _publish(self) -> None:
        scene = self._context.scene.snapshot()
        stamp = self._context.node.get_clock().now().to_msg()
        placed = [(self._context.frame, item) for item in scene.objects.values()]
        placed += [(item.link_name, item.object) for item in scene.attached.values()]
        for parent, item in placed:
            frame = f'{self._prefix}{item.id}'
            self._send(parent, frame, item.pose, stamp)
            for name, pose in item.subframes.items():
                self._send(frame, f'{frame}/{name}', pose, stamp)

    def _send(self, parent: str, child: str, pose: Matrix, stamp: Time) -> None:
        made = TransformStamped(child_frame_id=child)
        made.header.stamp, made.header.frame_id = stamp, parent
        place, turn = made.transform.translation, made.transform.rotation
        place.x, place.y, place.z = map(float, pose[:3, 3])
        turn.x, turn.y, turn.z, turn.w = map(float, quat_xyzw_from_matrix(pose))
        self._publisher.publish(TFMessage(transforms=[made]))


def _parameter(context: Context, name: str, default: Any) -> Any:
    """Return a parameter of the node, or its default."""
    node = context.node
    if not node.has_parameter(name):
        node.declare_parameter(name, default)
    return node.get_parameter(name).value
