# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The action ``~/gripper_cmd``, in the form of either gripper controller."""

from __future__ import annotations

from typing import Any

from control_msgs.action import GripperCommand, ParallelGripperCommand
from rclpy.node import Node
from sensor_msgs.msg import JointState

from armsim_ros.control.gripper.gripper_controller import (
    GripperController,
    ParallelGripperController,
)
from armsim_ros.nodes.simulation.controllers.goal_server import GoalServer
from armsim_ros.nodes.simulation.dispatcher import Dispatcher


class GripperCommandServer(GoalServer):
    """
    The action server of a position or effort gripper; no feedback, as in the reference.

    :param node: the controller's node.
    """

    def __init__(
        self, node: Node, controller: GripperController, dispatcher: Dispatcher
    ) -> None:
        self._controller = controller
        super().__init__(node, dispatcher, GripperCommand, '~/gripper_cmd')

    def _send(self, request: GripperCommand.Goal) -> Any:
        command = request.command
        return self._controller.send_goal(command.position, command.max_effort).goal

    def _cancel_goal(self, goal: Any) -> bool:
        return self._controller.cancel(goal)

    def _result(self, goal: Any) -> GripperCommand.Result:
        return GripperCommand.Result(
            position=goal.result.position,
            effort=goal.result.effort,
            stalled=goal.result.stalled,
            reached_goal=goal.result.reached_goal,
        )

    def _aborted(self, sentence: str) -> GripperCommand.Result:
        return GripperCommand.Result()  # it has no room for a sentence


class ParallelGripperCommandServer(GoalServer):
    """
    The action server of a parallel gripper; no feedback, as in the reference.

    :param node: the controller's node.
    """

    def __init__(
        self, node: Node, controller: ParallelGripperController, dispatcher: Dispatcher
    ) -> None:
        self._controller = controller
        super().__init__(node, dispatcher, ParallelGripperCommand, '~/gripper_cmd')

    def _send(self, request: ParallelGripperCommand.Goal) -> Any:
        command = request.command
        return self._controller.send_goal(
            list(command.position), list(command.velocity), list(command.effort)
        ).goal

    def _cancel_goal(self, goal: Any) -> bool:
        return self._controller.cancel(goal)

    def _result(self, goal: Any) -> ParallelGripperCommand.Result:
        state = JointState(
            name=list(self._controller.joints),
            position=[goal.result.position],
            velocity=[goal.result.velocity],
            effort=[goal.result.effort],
        )
        return ParallelGripperCommand.Result(
            state=state, stalled=goal.result.stalled, reached_goal=goal.result.reached_goal
        )

    def _aborted(self, sentence: str) -> ParallelGripperCommand.Result:
        return ParallelGripperCommand.Result()  # it has no room for a sentence
