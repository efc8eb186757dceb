# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Sends the parts of a trajectory to controllers of this process, as move_group does over ROS."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from armsim_ros.config.trajectory_execution import MoveItControllerSettings
from armsim_ros.control.command_controllers.gripper_controller import (
    GripperController,
    GripperGoal,
    GripperResponse,
    GripperResult,
    ParallelGripperController,
)
from armsim_ros.control.controller import Controller
from armsim_ros.control.mailbox import GoalStatus
from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.control.trajectory.goal import GoalResponse, TrajectoryGoal
from armsim_ros.control.trajectory.joint_trajectory_controller import JointTrajectoryController
from armsim_ros.errors import ControllerError, PlanningError
from armsim_ros.execution.controller_selection import (
    controller_parts,
    gripper_target,
    parallel_gripper_target,
)
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.trajectory import JointTrajectory


@dataclass(frozen=True)
class SentGoal:
    """
    A goal of a controller.

    :param settings: of the controller.
    """

    goal: TrajectoryGoal | GripperGoal
    settings: MoveItControllerSettings

    @property
    def succeeded(self) -> bool:
        """Whether the goal has succeeded, or was aborted where a gripper's may be."""
        aborted = self.goal.status is GoalStatus.ABORTED
        return self.goal.status is GoalStatus.SUCCEEDED or (
            aborted and isinstance(self.goal, GripperGoal) and self.settings.allow_failure)

    @property
    def failure(self) -> str:
        """What kept the goal from success."""
        result = self.goal.result
        if isinstance(result, GripperResult):
            return f"gripper '{self.settings.name}' " + (
                'stalled' if result.stalled else 'did not reach its goal')
        return result.message if result is not None else ''


def send_parts(
    trajectory: JointTrajectory, model: RobotModel,
    managers: Mapping[str, ControllerManager], known: Sequence[MoveItControllerSettings],
) -> list[SentGoal]:
    """
    Give a trajectory to the active controllers that have its joints; a gripper gets its end.

    :param managers: robot -> its controllers.
    :param known: the controllers of move_group, which define a gripper's command.
    :raises ControllerError: no controller has the joints, or a controller refuses the goal.
    """
    several = len(managers) > 1
    usable = {
        f'{robot}/{name}' if several else name: controller
        for robot, manager in managers.items()
        for name, controller in manager.controllers.items() if controller.active}
    found = {name: settings for name, controller in usable.items()
             if (settings := _settings(name, controller, known)) is not None}
    try:
        parts = controller_parts(trajectory, model, list(found.values()))
        for settings, part in parts:
            controller = usable[settings.name]
            reason = controller.check_goal(part) if isinstance(
                controller, JointTrajectoryController) else ''
            if reason:
                raise ControllerError(f"controller '{settings.name}' refuses: {reason}")
        return [_send(usable[settings.name], settings, part) for settings, part in parts]
    except PlanningError as error:
        raise ControllerError(str(error)) from None


def _settings(name: str, controller: Controller[Any], known: Sequence[MoveItControllerSettings]
              ) -> MoveItControllerSettings | None:
    """Return a controller as move_group knows it, None where trajectories cannot go to it."""
    if isinstance(controller, JointTrajectoryController):
        return MoveItControllerSettings(name=name, joints=controller.parameters.joints)
    if not isinstance(controller, (GripperController, ParallelGripperController)):
        return None
    own = next((candidate for candidate in known
                if candidate.name.rpartition('/')[2] == controller.name
                and controller.parameters.joint in candidate.joints), None)
    if own is not None:
        return own.model_copy(update={'name': name})
    return MoveItControllerSettings(name=name, joints=controller.joints)


def _send(controller: Controller[Any], settings: MoveItControllerSettings, part: JointTrajectory
          ) -> SentGoal:
    answer: GoalResponse | GripperResponse
    if isinstance(controller, JointTrajectoryController):
        answer = controller.send_goal(part)
    elif isinstance(controller, ParallelGripperController):
        target = parallel_gripper_target(part, settings)
        answer = controller.send_goal(
            [target.position], [settings.max_velocity] if settings.max_velocity > 0.0 else [],
            [settings.max_effort] if settings.max_effort > 0.0 else [])
    else:
        assert isinstance(controller, GripperController)
        target = gripper_target(part, settings)
        answer = controller.send_goal(
            target.position, settings.max_effort if target.effort is None else target.effort)
    if answer.goal is None:
        raise ControllerError(f"controller '{settings.name}' refuses: {answer.reason}")
    return SentGoal(answer.goal, settings)
