# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Frames of the planning scene's objects on ``/tf``: the capability TfPublisher."""

from __future__ import annotations

from collections.abc import Iterator

from geometry_msgs.msg import TransformStamped
from rclpy.clock import Clock, ClockType
from tf2_msgs.msg import TFMessage

from armsim_ros.arrays import Matrix
from armsim_ros.model.transforms import quat_xyzw_from_matrix
from armsim_ros.nodes import qos
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.planning.scene.objects import CollisionObject

RATE, PREFIX = 'planning_scene_frame_publishing_rate', 'planning_scene_tf_prefix'


class SceneFrames:
    """
    Publishes the frames of objects and their subframes, attached ones included.

    A frame is ``<prefix>/<object>`` or ``<prefix>/<object>/<subframe>``; the prefix is the node's
    name unless the parameter says otherwise, and '' is none.

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
        message = TFMessage()
        placed = [(self._context.frame, item) for item in scene.objects.values()]
        placed += [(item.link_name, item.object) for item in scene.attached.values()]
        for parent, item in placed:
            for name, pose in _frames(item):
                made = TransformStamped(child_frame_id=f'{self._prefix}{name}')
                made.header.stamp, made.header.frame_id = stamp, parent
                place, turn = made.transform.translation, made.transform.rotation
                place.x, place.y, place.z = map(float, pose[:3, 3])
                turn.x, turn.y, turn.z, turn.w = map(float, quat_xyzw_from_matrix(pose))
                message.transforms.append(made)
        if message.transforms:
            self._publisher.publish(message)


def _frames(item: CollisionObject) -> Iterator[tuple[str, Matrix]]:
    """Yield the frames of an object with their poses (4, 4) in the object's parent."""
    yield item.id, item.pose
    for name, pose in item.subframes.items():
        yield f'{item.id}/{name}', item.pose @ pose


def _parameter(context: Context, name: str, default: object) -> object:
    """Return a parameter of the node, or its default."""
    node = context.node
    if not node.has_parameter(name):
        node.declare_parameter(name, default)
    return node.get_parameter(name).value
