# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topics ``robot_description`` and ``robot_description_semantic``, where enabled."""

from __future__ import annotations

from armsim_ros.nodes.latched_text import publish_text
from armsim_ros.nodes.move_group.context import Context


class Descriptions:
    """
    Publishes a description whose parameter ``publish_...`` is true, as upstream does.

    :param context: has node and robot.
    """

    def __init__(self, context: Context) -> None:
        robot, node = context.robot, context.node
        texts = {'robot_description': robot.urdf, 'robot_description_semantic': robot.srdf}
        self._kept = [publish_text(node, name, text) for name, text in texts.items()
                      if node.has_parameter(f'publish_{name}')
                      and node.get_parameter(f'publish_{name}').value is True]
