# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""All endpoints of an arm of Franka."""

from __future__ import annotations

from typing import Any

from franka_msgs.action import ErrorRecovery
from rclpy.action import ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node

from armsim_ros.control.controller import Controller
from armsim_ros.errors import ControllerError, SimulationError
from armsim_ros.model.robot_model import JointType
from armsim_ros.nodes import qos
from armsim_ros.nodes.vendors.endpoints import ArmNodes, Endpoints
from armsim_ros.nodes.vendors.franka.gripper import Gripper
from armsim_ros.nodes.vendors.franka.services import ArmParameters, ParameterServices
from armsim_ros.nodes.vendors.franka.state_broadcaster import StateTopics

#: Of an arm.
JOINTS = 7


class FrankaEndpoints(Endpoints):
    """Error recovery, the services of parameters, the hand, and the state of the arm."""

    def __init__(self, nodes: ArmNodes) -> None:
        super().__init__(nodes)
        model = nodes.robot.model
        self._joints = tuple(name for name in model.active_joints
                             if model.joints[name].type is not JointType.PRISMATIC)[:JOINTS]
        self._parameters = ArmParameters()
        self._states: list[StateTopics] = []
        self._gripper: Gripper | None = None

    def create(self) -> None:
        """Create the nodes that the driver has beside its controllers."""
        nodes = self.nodes
        node = nodes.new_node('action_server')
        self._logger = node.get_logger()
        self._server = ActionServer(
            node, ErrorRecovery, '~/error_recovery', self._recover,
            callback_group=ReentrantCallbackGroup(), **qos.ACTION_SERVICES)
        ParameterServices(nodes, self._joints, self._parameters)
        end = nodes.arm.vendor.finger
        finger = next((name for name in nodes.robot.model.active_joints if name.endswith(end)), '')
        if finger:
            name = nodes.arm.settings.gripper or f'{finger.removesuffix(end)}_gripper'
            self._gripper = Gripper(nodes, finger, name)

    def open(self, controller: Controller[Any], node: Node) -> None:
        """Create the topics of a broadcaster of the arm's state."""
        if controller.type.endswith('/FrankaRobotStateBroadcaster') and self._joints:
            try:
                self._states.append(StateTopics(
                    self.nodes, controller, node, self._joints, self._parameters))
            except ControllerError as error:
                node.get_logger().error(f'no state of the arm: {error}')

    def publish(self, time_ns: int) -> None:
        """Publish states and feedback."""
        if self._gripper is not None:
            self._gripper.publish(time_ns)
        for topics in self._states:
            topics.publish(time_ns)

    @property
    def pending(self) -> int:
        """Goals of the hand without a result."""
        return self._gripper.pending if self._gripper is not None else 0

    def end(self, sentence: str) -> None:
        """Abort the goals of the hand."""
        if self._gripper is not None:
            self._gripper.end(sentence)

    async def _recover(self, handle: ServerGoalHandle) -> Any:
        try:
            refusal = await self.nodes.change(self.nodes.arm.clear_stop)
        except SimulationError as error:
            refusal = str(error)
        if refusal:
            self._logger.error(f'no recovery: {refusal}')
            handle.abort()
        else:
            handle.succeed()
        return ErrorRecovery.Result()
