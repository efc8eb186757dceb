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
from rclpy.task import Future
from sensor_msgs.msg import JointState

from armsim_ros.config.move_group.moveit_controllers import MoveItControllerSettings
from armsim_ros.nodes.conversions.trajectory import trajectory_to_message
from armsim_ros.trajectory import JointTrajectory


class ControllerRun:
    """
    One goal that was sent to a controller.

    Cancelling works at any time: a goal whose answer is still to come is cancelled when it is
    accepted after all.

    :param sent: done with the client's goal handle when the controller answers.
    :param read: result message -> (whether it succeeded, sentence).
    :param changed: called when an answer or the result is there.
    """

    def __init__(
        self,
        name: str,
        sent: Future,
        read: Callable[[Any], tuple[bool, str]],
        changed: Callable[[], None],
    ) -> None:
        self.name = name
        #: Whether the controller has refused the goal.
        self.rejected = False
        self._read = read
        self._changed = changed
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
        """Whether the goal ended because somebody cancelled it."""
        answer = self._answer()
        return answer is not None and answer.status == GoalStatus.STATUS_CANCELED

    @property
    def failure(self) -> str:
        """Why the goal did not succeed, '' when it did or has not ended."""
        if self.rejected:
            return 'the goal was rejected'
        answer = self._answer()
        if answer is None:
            return ''
        succeeded, text = self._read(answer.result)
        if answer.status == GoalStatus.STATUS_SUCCEEDED:
            return '' if succeeded else text
        return text or f'goal status {answer.status}'

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

    :param node: the node of the action client.
    :param settings: name, action and joints.
    :param changed: called when a goal's result is there.
    """

    action_type: Any

    def __init__(
        self, node: Node, settings: MoveItControllerSettings, changed: Callable[[], None]
    ) -> None:
        self.settings = settings
        self._changed = changed
        self._client = ActionClient(
            node,
            self.action_type,
            settings.action_name,
            callback_group=ReentrantCallbackGroup(),
        )

    @property
    def connected(self) -> bool:
        """Whether the action server is there."""
        return bool(self._client.server_is_ready())

    def send(self, trajectory: JointTrajectory) -> ControllerRun:
        """Send a trajectory; the returned run tells what became of it."""
        sent = self._client.send_goal_async(self.goal(trajectory))
        return ControllerRun(self.settings.name, sent, self.read, self._changed)

    @abstractmethod
    def goal(self, trajectory: JointTrajectory) -> Any:
        """Return the goal message of a trajectory."""

    @abstractmethod
    def read(self, result: Any) -> tuple[bool, str]:
        """Return whether a result means success, and its sentence."""


class FollowJointTrajectoryHandle(ControllerHandle):
    """A controller with a FollowJointTrajectory action."""

    action_type = FollowJointTrajectory

    def goal(self, trajectory: JointTrajectory) -> Any:
        """Return the goal: the trajectory starting now, tolerances left to the controller."""
        return FollowJointTrajectory.Goal(trajectory=trajectory_to_message(trajectory))

    def read(self, result: Any) -> tuple[bool, str]:
        """Return whether the error code is 0, and the controller's sentence."""
        succeeded = result.error_code == FollowJointTrajectory.Result.SUCCESSFUL
        return succeeded, result.error_string or f'error code {result.error_code}'


class GripperCommandHandle(ControllerHandle):
    """A gripper with a GripperCommand action; it goes to the last point's position."""

    action_type = GripperCommand

    def goal(self, trajectory: JointTrajectory) -> Any:
        """Return the goal: the command joint's last position."""
        goal = GripperCommand.Goal()
        goal.command.position = command_position(trajectory, self.settings)
        goal.command.max_effort = self.settings.max_effort
        return goal

    def read(self, result: Any) -> tuple[bool, str]:
        """Return whether the gripper arrived, or stalled where that may be."""
        succeeded = result.reached_goal or (result.stalled and self.settings.allow_failure)
        return bool(succeeded), 'the gripper stalled' if result.stalled else 'goal not reached'


class ParallelGripperCommandHandle(ControllerHandle):
    """A gripper with a ParallelGripperCommand action."""

    action_type = ParallelGripperCommand

    def goal(self, trajectory: JointTrajectory) -> Any:
        """Return the goal: the command joint's last position."""
        joint = self.settings.command_joint or self.settings.joints[0]
        command = JointState(
            name=[joint], position=[command_position(trajectory, self.settings)]
        )
        if self.settings.max_velocity > 0.0:
            command.velocity = [self.settings.max_velocity]
        if self.settings.max_effort > 0.0:
            command.effort = [self.settings.max_effort]
        return ParallelGripperCommand.Goal(command=command)

    def read(self, result: Any) -> tuple[bool, str]:
        """Return whether the gripper arrived, or stalled where that may be."""
        succeeded = result.reached_goal or (result.stalled and self.settings.allow_failure)
        return bool(succeeded), 'the gripper stalled' if result.stalled else 'goal not reached'


HANDLES: dict[str, type[ControllerHandle]] = {
    'FollowJointTrajectory': FollowJointTrajectoryHandle,
    'GripperCommand': GripperCommandHandle,
    'ParallelGripperCommand': ParallelGripperCommandHandle,
}


def command_position(trajectory: JointTrajectory, settings: MoveItControllerSettings) -> float:
    """Return the last position of a gripper's command joint [rad or m]."""
    joint = settings.command_joint or settings.joints[0]
    return float(trajectory.positions[-1, trajectory.joint_names.index(joint)])
