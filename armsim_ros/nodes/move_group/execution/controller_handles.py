# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Action clients of the controllers that trajectories are sent to."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.subscription import Subscription
from rclpy.task import Future
from std_msgs.msg import String

from armsim_ros.config.trajectory_execution import MoveItControllerSettings
from armsim_ros.execution.controller_selection import MultiDofTrajectory
from armsim_ros.nodes import qos
from armsim_ros.nodes.move_group.execution.controller_actions import action_of
from armsim_ros.trajectory import JointTrajectory


class ControllerRun:
    """
    A goal that was sent to a controller.

    Cancelling works at any time: a goal whose answer is still to come is cancelled when it is
    accepted after all.

    :param sent: done with the client's goal handle when the controller answers.
    :param handle: of the controller; it reads the result.
    :param changed: called when an answer or the result is there.
    """

    def __init__(
        self, sent: Future, handle: ControllerHandle, changed: Callable[[], None]
    ) -> None:
        self.name = handle.settings.name
        #: Whether the controller has refused the goal.
        self.rejected = False
        self._controller, self._changed = handle, changed
        self._handle: Any = None
        self._result: Future | None = None
        self._cancelling = False
        sent.add_done_callback(self._answered)

    def _answered(self, sent: Future) -> None:
        handle = sent.result()
        if handle is None or not handle.accepted:
            self.rejected = True
        else:
            self._handle = handle
            self._result = handle.get_result_async()
            self._result.add_done_callback(lambda _: self._changed())
            if self._cancelling:
                handle.cancel_goal_async()
        self._changed()

    @property
    def settings(self) -> MoveItControllerSettings:
        """The parameters of the controller."""
        return self._controller.settings

    @property
    def connected(self) -> bool:
        """Whether the action server of the controller is there."""
        return self._controller.connected

    @property
    def answered(self) -> bool:
        """Whether the controller has accepted or refused the goal."""
        return self.rejected or self._handle is not None

    @property
    def done(self) -> bool:
        """Whether the goal has ended, or was never begun."""
        return self.rejected or (self._result is not None and bool(self._result.done()))

    @property
    def failed(self) -> bool:
        """Whether the goal has ended without success."""
        return self.done and bool(self.failure)

    @property
    def canceled(self) -> bool:
        """Whether the goal ended because it was cancelled."""
        answer = self._answer()
        return answer is not None and answer.status == GoalStatus.STATUS_CANCELED

    @property
    def failure(self) -> str:
        """Why the goal did not succeed, '' when it did or has not ended."""
        if self.rejected:
            return 'the goal was rejected'
        answer = self._answer()
        return '' if answer is None else self._controller.action.failure(
            answer.status, answer.result)

    def cancel(self) -> None:
        """Ask the controller to stop; asking twice does no harm."""
        if not self.done and not self._cancelling:
            self._cancelling = True
            if self._handle is not None:
                self._handle.cancel_goal_async()

    def _answer(self) -> Any:
        return self._result.result() if self._result is not None and self.done else None


class ControllerHandle:
    """
    A controller that trajectories can be sent to.

    :param settings: name, action and joints.
    :param changed: called when a goal's result is there.
    """

    def __init__(
        self, node: Node, settings: MoveItControllerSettings, changed: Callable[[], None]
    ) -> None:
        self.settings, self._node, self._changed = settings, node, changed
        self.action = action_of(settings, node.get_logger().warning)
        self._reasons: Subscription | None = None
        self._reason = ''
        self._client = ActionClient(
            node, self.action.type, settings.action_name, callback_group=ReentrantCallbackGroup())

    @property
    def connected(self) -> bool:
        """Whether the action server is there."""
        return bool(self._client.server_is_ready())

    def send(
        self, trajectory: JointTrajectory, multi_dof: MultiDofTrajectory | None = None
    ) -> ControllerRun:
        """
        Send a part of a trajectory; the returned run reports its end.

        :raises PlanningError: CONTROL_FAILED where the controller cannot run such a part.
        """
        self._reason = ''
        sent = self._client.send_goal_async(self.action.goal(trajectory, multi_dof))
        return ControllerRun(sent, self, self._changed)

    @property
    def publishes_reasons(self) -> bool:
        """Whether the controller publishes why it rejects a goal; those of ros2_control do not."""
        return self._node.count_publishers(self.action.reason_topic) > 0

    @property
    def reason(self) -> str:
        """
        Why the controller has rejected a goal, '' until that has arrived.

        The topic is latched: to subscribe when the reason is needed is soon enough.
        """
        if self._reasons is None:
            self._reasons = self._node.create_subscription(
                String, self.action.reason_topic, self._take_reason, qos.LATCHED,
                callback_group=ReentrantCallbackGroup())
        return self._reason

    def _take_reason(self, message: String) -> None:
        self._reason = message.data
        self._changed()

    def close(self) -> None:
        """Remove the action client."""
        self._client.destroy()
        if self._reasons is not None:
            self._node.destroy_subscription(self._reasons)
