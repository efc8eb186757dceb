# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Arms of Kinova, as ``ros2_kortex`` presents them: faults, and twists of the tool."""

from __future__ import annotations

from typing import Any

from example_interfaces.msg import Bool
from example_interfaces.srv import Trigger
from geometry_msgs.msg import Twist
import numpy as np
from rclpy.node import Node

from armsim_ros.control.command_controllers.twist_drive import TwistDrive
from armsim_ros.control.controller import Controller
from armsim_ros.errors import ControllerError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes import qos
from armsim_ros.nodes.vendors.endpoints import ArmNodes, Endpoints


class KinovaEndpoints(Endpoints):
    """What the controllers of PickNik's packages offer."""

    def open(self, controller: Controller[Any], node: Node) -> None:
        """Create the endpoints of a fault controller, or of a twist controller."""
        kind = controller.type.rpartition('/')[2]
        if kind == 'PicknikResetFaultController':
            self.add(controller, FaultEndpoints(self.nodes, controller, node))
        elif kind == 'PicknikTwistController':
            try:
                TwistCommands(self.nodes, controller, node)
            except ControllerError as error:
                node.get_logger().error(f'no twists: {error}')


class FaultEndpoints:
    """``internal_fault`` and ``reset_fault``; any stop of the arm is a fault."""

    def __init__(self, nodes: ArmNodes, controller: Controller[Any], node: Node) -> None:
        self._nodes, self._controller = nodes, controller
        self._publisher = node.create_publisher(Bool, '~/internal_fault', 1)
        nodes.once_active(controller, node, lambda: nodes.service(
            node, Trigger, '~/reset_fault', self._reset))

    def publish(self, time_ns: int) -> None:
        """Publish whether the arm is stopped."""
        if self._controller.active and self._publisher.get_subscription_count():
            self._publisher.publish(Bool(data=self._nodes.arm.stopped))

    def _reset(self, _: Trigger.Request, response: Trigger.Response) -> None:
        response.message = self._nodes.arm.clear_stop() if self._controller.active else (
            'the controller is not active')
        response.success = not response.message


class TwistCommands:
    """The topic ``commands``: twists in the frame of the tool."""

    def __init__(self, nodes: ArmNodes, controller: Controller[Any], node: Node) -> None:
        self._controller = controller
        model, end = nodes.robot.model, nodes.arm.vendor.tool
        tool = next((name for name in model.links if name.endswith(end)), '')
        if not tool:
            raise ControllerError(f"the robot has no link '{end}'")
        self._drive = TwistDrive.of(
            controller.name, _joints_to(model, tool), tool, nodes.manager.context)
        nodes.loop.call(lambda: nodes.manager.attach(self._drive))
        node.create_subscription(Twist, '~/commands', self._receive, qos.COMMAND)

    def _receive(self, message: Twist) -> None:
        if self._controller.active:
            parts = message.linear, message.angular
            self._drive.receive(np.array([
                getattr(part, axis) for part in parts for axis in 'xyz']))


def _joints_to(model: RobotModel, link: str) -> list[str]:
    """Return the joints that move a link, from the base on."""
    found: list[str] = []
    while (name := model.parent_joint.get(link)) is not None:
        if model.joints[name].active:
            found.insert(0, name)
        link = model.joints[name].parent
    return found
