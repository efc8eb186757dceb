# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``/robot_description_semantic``."""

from __future__ import annotations

from rclpy.node import Node
from rclpy.publisher import Publisher

from armsim_ros.nodes.simulation.robot_description import publish_text


def publish_robot_description_semantic(node: Node, srdf: str) -> Publisher:
    """
    Publish the SRDF once, for all who come later too.

    :param node: the node that publishes.
    :param srdf: the SRDF text.
    :returns: the publisher, which must be kept alive.
    """
    return publish_text(node, 'robot_description_semantic', srdf)
