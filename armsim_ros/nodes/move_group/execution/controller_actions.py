# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Actions of the controllers that trajectories are sent to: goals, and what results mean."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalStatus
from control_msgs.action import FollowJointTrajectory, GripperCommand, ParallelGripperCommand
from sensor_msgs.msg import JointState

from armsim_ros.config.trajectory_execution import MoveItControllerSettings
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.execution.controller_selection import (
    gripper_target,
    MultiDofTrajectory,
    parallel_gripper_target,
)
from armsim_ros.nodes.conversions.trajectory import multi_dof_to_message, trajectory_to_message
from armsim_ros.trajectory import JointTrajectory


class ControllerAction(ABC):
    """
    The action of a controller.

    :param settings: name, action and joints.
    :param warn: takes a warning.
    """

    type: Any

    def __init__(
        self, settings: MoveItControllerSettings, warn: Callable[[str], Any]
    ) -> None:
        self.settings, self._warn = settings, warn

    @property
    def reason_topic(self) -> str:
        """Topic of why a goal was rejected; only our controllers have it."""
        return f"{self.settings.action_name.rpartition('/')[0]}/rejected_goals"

    @abstractmethod
    def goal(
        self, trajectory: JointTrajectory, multi_dof: MultiDofTrajectory | None = None
    ) -> Any:
        """
        Return the goal message of a part of a trajectory.

        :raises PlanningError: CONTROL_FAILED where the controller cannot run such a part.
        """

    def failure(self, status: int, result: Any) -> str:
        """
        Return why a goal that has ended did not succeed, '' where it did.

        :param status: of the goal, which decides; the result has the sentence.
        """
        if self._succeeded(status):
            return ''
        return self._sentence(result) or f'goal status {status}'

    def _succeeded(self, status: int) -> bool:
        return status == GoalStatus.STATUS_SUCCEEDED

    @abstractmethod
    def _sentence(self, result: Any) -> str:
        """Return the controller's description of a failure, '' where it has none."""


class FollowJointTrajectoryAction(ControllerAction):
    """A controller with a FollowJointTrajectory action."""

    type = FollowJointTrajectory

    def goal(
        self, trajectory: JointTrajectory, multi_dof: MultiDofTrajectory | None = None
    ) -> Any:
        """Return the goal: the part as it is, tolerances left to the controller."""
        goal = FollowJointTrajectory.Goal(trajectory=trajectory_to_message(trajectory))
        if multi_dof is not None:
            goal.multi_dof_trajectory = multi_dof_to_message(multi_dof)
        return goal

    def _sentence(self, result: Any) -> str:
        """Return the controller's sentence, or its error code."""
        failed = result.error_code != FollowJointTrajectory.Result.SUCCESSFUL
        return result.error_string or (f'error code {result.error_code}' if failed else '')


class GripperAction(ControllerAction):
    """A controller of a gripper."""

    def goal(
        self, trajectory: JointTrajectory, multi_dof: MultiDofTrajectory | None = None
    ) -> Any:
        """Return the goal: the last position of the command joint."""
        if multi_dof is not None or not len(trajectory):
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                f"gripper controller '{self.settings.name}' cannot run multi-DOF trajectories")
        return self._command(trajectory)

    def _sentence(self, result: Any) -> str:
        """Return what kept the gripper from its goal."""
        return 'the gripper stalled' if result.stalled else 'goal not reached'

    @abstractmethod
    def _command(self, trajectory: JointTrajectory) -> Any:
        """Return the goal message."""


class GripperCommandAction(GripperAction):
    """A gripper with a GripperCommand action."""

    type = GripperCommand

    def _succeeded(self, status: int) -> bool:
        """Return whether the goal has succeeded, or was aborted where that is allowed."""
        aborted = status == GoalStatus.STATUS_ABORTED
        return (aborted and self.settings.allow_failure) or super()._succeeded(status)

    def _command(self, trajectory: JointTrajectory) -> Any:
        settings = self.settings
        target = gripper_target(trajectory, settings)
        if target.assumed:
            self._warn(
                f"controller '{settings.name}': the trajectory has no command joint "
                f"'{settings.command_joint or settings.joints[0]}'; the position of "
                f"'{target.joint}' is sent")
        goal = GripperCommand.Goal()
        goal.command.position = target.position
        goal.command.max_effort = (settings.max_effort if target.effort is None else target.effort)
        return goal


class ParallelGripperCommandAction(GripperAction):
    """A gripper with a ParallelGripperCommand action."""

    type = ParallelGripperCommand

    def _command(self, trajectory: JointTrajectory) -> Any:
        target = parallel_gripper_target(trajectory, self.settings)
        command = JointState(name=[target.joint], position=[target.position])
        if self.settings.max_velocity > 0.0:
            command.velocity = [self.settings.max_velocity]
        if self.settings.max_effort > 0.0:
            command.effort = [self.settings.max_effort]
        return ParallelGripperCommand.Goal(command=command)


_ACTIONS: dict[str, type[ControllerAction]] = {
    'FollowJointTrajectory': FollowJointTrajectoryAction,
    'GripperCommand': GripperCommandAction,
    'ParallelGripperCommand': ParallelGripperCommandAction,
}


def action_of(
    settings: MoveItControllerSettings, warn: Callable[[str], Any]
) -> ControllerAction:
    """Return the action of a controller; its warnings go to a function."""
    return _ACTIONS[settings.type](settings, warn)
