# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Topics that command a controller: ``~/commands``, ``~/joint_trajectory`` and scaling."""

from __future__ import annotations

from control_msgs.msg import SpeedScalingFactor
from rclpy.node import Node
from std_msgs.msg import Float64, Float64MultiArray
from trajectory_msgs.msg import JointTrajectory

from armsim_ros.control.command_controllers.forward_command_controller import ForwardController
from armsim_ros.control.trajectory.joint_trajectory_controller import JointTrajectoryController
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.trajectory import trajectory_from_message


class Commands:
    """
    Passes commands to a forward controller; the events report why a command is dropped.

    :param node: the controller's node.
    """

    def __init__(self, node: Node, controller: ForwardController) -> None:
        self._controller = controller
        if controller.single:
            self._subscriptions = [
                node.create_subscription(Float64, '~/command', self._receive_one, qos.COMMAND)
            ]
        else:
            self._subscriptions = [
                node.create_subscription(Float64MultiArray, name, self._receive, qos.COMMAND)
                for name in ('~/commands', '~/command')
            ]

    def _receive(self, message: Float64MultiArray) -> None:
        self._controller.receive(message.data)

    def _receive_one(self, message: Float64) -> None:
        self._controller.receive((message.data,))


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
