# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Waits for a robot description that another node publishes."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String

from armsim_ros.nodes import qos
from armsim_ros.nodes.originals.node_parameters import NodeArguments

#: Period of reporting what is waited for [s].
_REMINDER = 5.0


def wait_for_descriptions(
    arguments: NodeArguments, topics: Sequence[str], needed: Sequence[str] = ()
) -> dict[str, str]:
    """
    Return topic -> text.

    :param topics: names relative to the node.
    :param needed: those to wait for; the first of all that comes, where empty.
    """
    context = rclpy.Context()
    rclpy.init(args=arguments.ros_args(with_name=True), context=context)
    found: dict[str, str] = {}
    try:
        node = Node(f'{arguments.name}_waits', context=context, use_global_arguments=True,
                    enable_rosout=False, start_parameter_services=False)
        for topic in topics:
            node.create_subscription(
                String, topic, partial(_note, found, topic), qos.LATCHED)
        node.create_timer(_REMINDER, lambda: node.get_logger().info(
            f"waiting for the topic {' or '.join(topics)}"))
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        while not found or any(topic not in found for topic in needed):
            executor.spin_once()
        node.destroy_node()
    finally:
        context.try_shutdown()
    return found


def _note(found: dict[str, str], topic: str, message: String) -> None:
    found.setdefault(topic, message.data)
