# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``~/speed_scaling_input``."""

from __future__ import annotations

from control_msgs.msg import SpeedScalingFactor
from rclpy.node import Node

from armsim_ros.control.trajectory.joint_trajectory_controller import JointTrajectoryController
from armsim_ros.nodes import qos


class SpeedScalingInput:
    """
    Takes the pace of trajectories; volatile and best effort, so that every publisher matches.

    :param node: the controller's node.
    """

    def __init__(self, node: Node, controller: JointTrajectoryController) -> None:
        self._controller = controller
        self._subscription = node.create_subscription(
            SpeedScalingFactor, '~/speed_scaling_input', self._receive, qos.COMMAND
        )

    def _receive(self, message: SpeedScalingFactor) -> None:
        self._controller.set_speed_scaling(message.factor)
