# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Action clients of the controllers that trajectories are sent to."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalStatus
from control_msgs.action import FollowJointTrajectory, GripperCommand, ParallelGripperCommand
from rclpy.action import ActionClient
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.subscription import Subscription
from rclpy.task import Future
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from armsim_ros.config.trajectory_execution import MoveItControllerSettings
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.execution.controller_selection import (
    gripper_target,
    MultiDofTrajectory,
    parallel_gripper_target,
)
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.trajectory import multi_dof_to_message, trajectory_to_message
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
        if answer is None or self._controller.succeeded(answer.status):
            return ''
        return self._controller.sentence(answer.result) or f'goal status {answer.status}'

    def cancel(self) -> None:
        """Ask the controller to stop; asking twice does no harm."""
        if not self.done and not self._cancelling:
            self._cancelling = True
            if self._handle is not None:
                self._handle.cancel_goal_async()

    def _answer(self) -> Any:
        return self._result.result() if self._result is not None and self.done else None


class ControllerHandle(ABC):
    """
    A controller that trajectories can be sent to.

    :param settings: name, action and joints.
    :param changed: called when a goal's result is there.
    """

    action_type: Any

    def __init__(
        self, node: Node, settings: MoveItControllerSettings, changed: Callable[[], None]
    ) -> None:
        self.settings, self._node, self._changed = settings, node, changed
        self._reasons: Subscription | None = None
        self._reason = ''
        self._client = ActionClient(
            node, self.action_type, settings.action_name, callback_group=ReentrantCallbackGroup())

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
        sent = self._client.send_goal_async(self.goal(trajectory, multi_dof))
        return ControllerRun(sent, self, self._changed)

    @property
    def publishes_reasons(self) -> bool:
        """Whether the controller publishes why it rejects a goal; those of ros2_control do not."""
        return self._node.count_publishers(self._reason_topic) > 0

    @property
    def reason(self) -> str:
        """
        Why the controller has rejected a goal, '' until that has arrived.

        The topic is latched: to subscribe when the reason is needed is soon enough.
        """
        if self._reasons is None:
            self._reasons = self._node.create_subscription(
                String, self._reason_topic, self._take_reason, qos.LATCHED,
                callback_group=ReentrantCallbackGroup())
        return self._reason

    @property
    def _reason_topic(self) -> str:
        return f"{self.settings.action_name.rpartition('/')[0]}/rejected_goals"

    def _take_reason(self, message: String) -> None:
        self._reason = message.data
        self._changed()

    def succeeded(self, status: int) -> bool:
        """Return whether a goal with this status has succeeded; the result is not read."""
        return status == GoalStatus.STATUS_SUCCEEDED

    def close(self) -> None:
        """Remove the action client."""
        self._client.destroy()
        if self._reasons is not None:
            self._node.destroy_subscription(self._reasons)

    @abstractmethod
    def goal(self, trajectory: JointTrajectory, multi_dof: MultiDofTrajectory | None) -> Any:
        """Return the goal message of a part."""

    @abstractmethod
    def sentence(self, result: Any) -> str:
        """Return the controller's description of a failure, '' where it has none."""


class FollowJointTrajectoryHandle(ControllerHandle):
    """A controller with a FollowJointTrajectory action."""

    action_type = FollowJointTrajectory

    def goal(self, trajectory: JointTrajectory, multi_dof: MultiDofTrajectory | None) -> Any:
        """Return the goal: the part as it is, tolerances left to the controller."""
        goal = FollowJointTrajectory.Goal(trajectory=trajectory_to_message(trajectory))
        if multi_dof is not None:
            goal.multi_dof_trajectory = multi_dof_to_message(multi_dof)
        return goal

    def sentence(self, result: Any) -> str:
        """Return the controller's sentence, or its error code."""
        failed = result.error_code != FollowJointTrajectory.Result.SUCCESSFUL
        return result.error_string or (f'error code {result.error_code}' if failed else '')


class GripperHandle(ControllerHandle):
    """A controller of a gripper."""

    def goal(self, trajectory: JointTrajectory, multi_dof: MultiDofTrajectory | None) -> Any:
        """Return the goal: the last position of the command joint."""
        if multi_dof is not None or not len(trajectory):
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                f"gripper controller '{self.settings.name}' cannot run multi-DOF trajectories")
        return self._command(trajectory)

    def sentence(self, result: Any) -> str:
        """Return what kept the gripper from its goal."""
        return 'the gripper stalled' if result.stalled else 'goal not reached'

    @abstractmethod
    def _command(self, trajectory: JointTrajectory) -> Any:
        """Return the goal message."""


class GripperCommandHandle(GripperHandle):
    """A gripper with a GripperCommand action."""

    action_type = GripperCommand

    def succeeded(self, status: int) -> bool:
        """Return whether the goal has succeeded, or was aborted where that is allowed."""
        aborted = status == GoalStatus.STATUS_ABORTED
        return (aborted and self.settings.allow_failure) or super().succeeded(status)

    def _command(self, trajectory: JointTrajectory) -> Any:
        settings = self.settings
        target = gripper_target(trajectory, settings)
        if target.assumed:
            self._node.get_logger().warning(
                f"controller '{settings.name}': the trajectory has no command joint "
                f"'{settings.command_joint or settings.joints[0]}'; the position of "
                f"'{target.joint}' is sent")
        goal = GripperCommand.Goal()
        goal.command.position = target.position
        goal.command.max_effort = (settings.max_effort if target.effort is None else target.effort)
        return goal


class ParallelGripperCommandHandle(GripperHandle):
    """A gripper with a ParallelGripperCommand action."""

    action_type = ParallelGripperCommand

    def _command(self, trajectory: JointTrajectory) -> Any:
        target = parallel_gripper_target(trajectory, self.settings)
        command = JointState(name=[target.joint], position=[target.position])
        if self.settings.max_velocity > 0.0:
            command.velocity = [self.settings.max_velocity]
        if self.settings.max_effort > 0.0:
            command.effort = [self.settings.max_effort]
        return ParallelGripperCommand.Goal(command=command)


HANDLES: dict[str, type[ControllerHandle]] = {
    'FollowJointTrajectory': FollowJointTrajectoryHandle,
    'GripperCommand': GripperCommandHandle,
    'ParallelGripperCommand': ParallelGripperCommandHandle,
}
