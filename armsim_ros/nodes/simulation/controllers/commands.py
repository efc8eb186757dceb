# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``~/commands`` of a forward controller; ``~/command`` is ROS 1's name of it."""

from __future__ import annotations

from rclpy.node import Node
from std_msgs.msg import Float64, Float64MultiArray

from armsim_ros.control.command_controllers.forward_command_controller import ForwardController
from armsim_ros.nodes import qos


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
