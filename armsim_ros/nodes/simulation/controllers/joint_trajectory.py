# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``~/joint_trajectory``."""

from __future__ import annotations

from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory

from armsim_ros.control.trajectory.joint_trajectory_controller import JointTrajectoryController
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.trajectory import trajectory_from_message


class JointTrajectorySubscription:
    """
    Takes trajectories without a goal; the controller's events report why a trajectory is refused.

    :param node: the controller's node.
    """

    def __init__(self, node: Node, controller: JointTrajectoryController) -> None:
        self._controller = controller
        self._subscription = node.create_subscription(
            JointTrajectory, '~/joint_trajectory', self._receive, qos.COMMAND
        )

    def _receive(self, message: JointTrajectory) -> None:
        self._controller.set_trajectory(trajectory_from_message(message))
