# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``display_planned_path``."""

from __future__ import annotations

from moveit_msgs.msg import DisplayTrajectory, RobotState, RobotTrajectory
from rclpy.node import Node

from armsim_ros.config.move_group.ompl_planning import OmplSettings
from armsim_ros.nodes.conversions.motion_plan_request import display_trajectory_message
from armsim_ros.nodes.move_group.planning.adapters import response_adapters
from armsim_ros.planning.pilz.commands import PIPELINE as PILZ

TOPIC = 'display_planned_path'


class DisplayPlannedPath:
    """
    Publishes trajectories, for RViz to animate.

    A pipeline publishes its plans where its response adapters have DisplayMotionPath, on the
    topic ``<pipeline>.display_path_topic``; compute_cartesian_path always does.

    :param node: the node that publishes.
    :param model_id: the robot's name.
    :param settings: of the pipelines.
    """

    def __init__(self, node: Node, model_id: str, settings: OmplSettings) -> None:
        self._model_id = model_id
        self._settings = settings
        self._publishers = {
            topic: node.create_publisher(DisplayTrajectory, topic, 10)
            for topic in {TOPIC, settings.display_path_topic}
        }

    def publish(
        self, start: RobotState, trajectory: RobotTrajectory, topic: str = TOPIC
    ) -> None:
        """Publish a trajectory and the state that it begins in."""
        self._publishers[topic].publish(
            display_trajectory_message(self._model_id, [trajectory], start))

    def publish_plan(
        self, pipeline: str, start: RobotState, trajectory: RobotTrajectory
    ) -> None:
        """Publish what a pipeline has planned, if it is configured to."""
        if 'DisplayMotionPath' in response_adapters(self._settings, pipeline):
            topic = TOPIC if pipeline == PILZ else self._settings.display_path_topic
            self.publish(start, trajectory, topic)
