# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The action ``execute_trajectory``."""

from __future__ import annotations

from typing import Any

from moveit_msgs.action import ExecuteTrajectory as Action
from moveit_msgs.msg import RobotTrajectory
from rclpy.action.server import ServerGoalHandle

from armsim_ros.errors import MoveItErrorCode
from armsim_ros.execution.multi_dof import as_joint_trajectory, MultiDofTrajectory
from armsim_ros.nodes.conversions.trajectory import (
    multi_dof_from_message,
    trajectory_from_message,
)
from armsim_ros.nodes.move_group.action_server import MoveGroupActionServer
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.execution.execution import ExecutionWatch
from armsim_ros.nodes.move_group.execution.trajectory_execution import TrajectoryExecutionManager
from armsim_ros.nodes.move_group.failures import fill_error, reported
from armsim_ros.trajectory import JointTrajectory


class ExecuteTrajectory:
    """
    Runs a client's trajectories; goals wait for each other.

    :param context: the parts of move_group.
    :param execution: sends them to the controllers.
    """

    def __init__(self, context: Context, execution: TrajectoryExecutionManager) -> None:
        self._context = context
        self._execution = execution
        self._server = MoveGroupActionServer(context, Action, 'execute_trajectory', self._execute)

    async def _execute(self, goal: ServerGoalHandle) -> Any:
        result = Action.Result()
        fill_error(result.error_code, MoveItErrorCode.FAILURE, 'not executed', 'execution')
        goal.publish_feedback(Action.Feedback(state='MONITOR'))
        with reported(self._context.logger, 'execute_trajectory', result.error_code):
            trajectory, multi_dof = robot_trajectory(self._context, goal.request.trajectory)
            outcome = await self._execution.queued(
                trajectory,
                ExecutionWatch(cancelled=lambda: goal.is_cancel_requested),
                goal.request.controller_names,
                multi_dof,
            )
            fill_error(result.error_code, outcome.code, outcome.message, 'execution')
            if not outcome.success:
                self._context.logger.error(f'execute_trajectory: {outcome.message}')
        sentence = result.error_code.message or 'Solution was found and executed.'
        goal.publish_feedback(Action.Feedback(state=sentence))
        goal.publish_feedback(Action.Feedback(state='IDLE'))
        self._server.end(goal, result.error_code.val)
        return result


def robot_trajectory(
    context: Context, message: RobotTrajectory
) -> tuple[JointTrajectory, MultiDofTrajectory | None]:
    """
    Return the trajectories of a message's joints and multi-DOF joints.

    With ``control_multi_dof_joint_variables`` the variables of the latter are joints.

    :raises PlanningError: CONTROL_FAILED where they do not fit their joints.
    """
    trajectory = trajectory_from_message(message.joint_trajectory)
    multi_dof = multi_dof_from_message(message.multi_dof_joint_trajectory)
    if multi_dof is None or not context.execution_settings.control_multi_dof_joint_variables:
        return trajectory, multi_dof
    return as_joint_trajectory(trajectory, multi_dof, context.robot), None
