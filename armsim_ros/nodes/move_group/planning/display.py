# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topics ``display_planned_path`` and ``display_contacts``: a plan, or what refused it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from moveit_msgs.msg import DisplayTrajectory, RobotState, RobotTrajectory
from rclpy.node import Node
from visualization_msgs.msg import Marker, MarkerArray

from armsim_ros.config.move_group.ompl_planning import OmplSettings
from armsim_ros.nodes.conversions.motion_plan_request import display_trajectory_message
from armsim_ros.nodes.move_group.planning.planner_services import response_adapters
from armsim_ros.planning.collision.contacts import Contact
from armsim_ros.planning.pilz.commands import PIPELINE as PILZ

#: Contacts of a state that are shown, the diameter of a marker [m], its lifetime in RViz [s].
MOST, SIZE, LIFETIME = 10, 0.07, 60


class DisplayContacts:
    """
    Publishes contacts as MoveIt does: red spheres, those of the previous plan deleted first.

    :param topic: '' publishes nothing.
    :param frame: of the contacts: the model frame.
    """

    def __init__(self, node: Node, topic: str, frame: str) -> None:
        self._node, self._frame = node, frame
        self._publisher = node.create_publisher(MarkerArray, topic, 10) if topic else None

    def publish(self, contacts: Sequence[Contact]) -> None:
        """Publish contacts in a message, if it has subscribers."""
        if self._publisher is None or not self._publisher.get_subscription_count():
            return
        markers = [Marker(action=Marker.DELETEALL)]
        seen: Counter[str] = Counter()
        for contact in contacts[:MOST]:
            pair = f'{contact.body1}={contact.body2}'
            markers.append(self._marker(pair, seen[pair], contact))
            seen[pair] += 1
        self._publisher.publish(MarkerArray(markers=markers))

    def _marker(self, pair: str, number: int, contact: Contact) -> Marker:
        marker = Marker(ns=pair, id=number, type=Marker.SPHERE, action=Marker.ADD)
        marker.header.frame_id = self._frame
        marker.header.stamp = self._node.get_clock().now().to_msg()
        place = marker.pose.position
        place.x, place.y, place.z = map(float, contact.position)
        marker.pose.orientation.w = 1.0
        marker.scale.x = marker.scale.y = marker.scale.z = SIZE
        marker.color.r, marker.color.a = 1.0, 0.8
        marker.lifetime.sec = LIFETIME
        return marker


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
