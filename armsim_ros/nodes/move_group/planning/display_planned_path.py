# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``display_planned_path``."""

from __future__ import annotations

from moveit_msgs.msg import DisplayTrajectory, RobotState, RobotTrajectory
from rclpy.node import Node

from armsim_ros.nodes.conversions.motion_plan_request import display_trajectory_message

TOPIC = 'display_planned_path'


class DisplayPlannedPath:
    """
    Publishes every planned trajectory, for RViz to animate.

    :param node: the node that publishes.
    :param model_id: the robot's name.
    """

    def __init__(self, node: Node, model_id: str) -> None:
        self._model_id = model_id
        self._publisher = node.create_publisher(DisplayTrajectory, TOPIC, 10)

    def publish(self, start: RobotState, *trajectories: RobotTrajectory) -> None:
        """Publish trajectories that follow each other and the state that they begin with."""
        self._publisher.publish(
            display_trajectory_message(self._model_id, trajectories, start)
        )
