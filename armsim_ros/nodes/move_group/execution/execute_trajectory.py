# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The actions ``execute_trajectory`` and ``execute_task_solution``."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from moveit_msgs.action import ExecuteTrajectory as TrajectoryAction
from moveit_msgs.msg import RobotTrajectory
from moveit_task_constructor_msgs.action import ExecuteTaskSolution as SolutionAction
from moveit_task_constructor_msgs.msg import SubTrajectory
from rclpy.action.server import ServerGoalHandle
from sensor_msgs.msg import JointState, MultiDOFJointState

from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.execution.controller_selection import as_joint_trajectory, MultiDofTrajectory
from armsim_ros.nodes.conversions.planning_scene import is_empty
from armsim_ros.nodes.conversions.trajectory import multi_dof_from_message, trajectory_from_message
from armsim_ros.nodes.move_group.context import (
    Context,
    fill_error,
    MoveGroupActionServer,
    reported,
)
from armsim_ros.nodes.move_group.execution.controller_managers import selected_controllers
from armsim_ros.nodes.move_group.execution.execution import ExecutionWatch
from armsim_ros.nodes.move_group.execution.trajectory_execution import (
    PathWatch,
    TrajectoryExecutionManager,
)
from armsim_ros.nodes.move_group.scene.scene_topics import apply_scene_message
from armsim_ros.trajectory import JointTrajectory


class ExecuteTrajectory:
    """Runs a client's trajectories; goals wait for each other."""

    def __init__(self, context: Context, execution: TrajectoryExecutionManager) -> None:
        self._context, self._execution = context, execution
        self._server = MoveGroupActionServer(
            context, TrajectoryAction, 'execute_trajectory', self._execute)

    async def _execute(self, goal: ServerGoalHandle) -> Any:
        result = TrajectoryAction.Result()
        fill_error(result.error_code, MoveItErrorCode.FAILURE, 'not executed', 'execution')
        goal.publish_feedback(TrajectoryAction.Feedback(state='MONITOR'))
        with reported(self._context.logger, 'execute_trajectory', result.error_code):
            trajectory, multi_dof = robot_trajectory(self._context, goal.request.trajectory)
            outcome = await self._execution.queued(
                trajectory, ExecutionWatch(cancelled=lambda: goal.is_cancel_requested),
                goal.request.controller_names, multi_dof)
            fill_error(result.error_code, outcome.code, outcome.message, 'execution')
            if not outcome.success:
                self._context.logger.error(f'execute_trajectory: {outcome.message}')
        sentence = result.error_code.message or 'Solution was found and executed.'
        goal.publish_feedback(TrajectoryAction.Feedback(state=sentence))
        goal.publish_feedback(TrajectoryAction.Feedback(state='IDLE'))
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


SOURCE = 'execute_task_solution'

_Motion = tuple[JointTrajectory, MultiDofTrajectory | None]


class ExecuteTaskSolution:
    """
    Runs solutions of MoveIt Task Constructor.

    All parts are checked before any motion starts. What is in the way of a part, or comes into
    it, stops the arm. What a part changes in the scene is changed when its motion has ended well;
    a part that fails, or whose change is refused, ends the whole.
    """

    def __init__(self, context: Context, execution: TrajectoryExecutionManager) -> None:
        self._context, self._execution = context, execution
        self._grouped = {
            joint
            for group in context.robot.semantic.groups.values()
            for joint in group.active_joints}
        self._server = MoveGroupActionServer(context, SolutionAction, SOURCE, self._execute)

    async def _execute(self, goal: ServerGoalHandle) -> Any:
        result = SolutionAction.Result()
        fill_error(result.error_code, MoveItErrorCode.FAILURE, 'not executed', SOURCE)
        with reported(self._context.logger, SOURCE, result.error_code):
            await self._execution.controllers.refresh()
            parts = goal.request.solution.sub_trajectory
            trajectories = self._checked(parts)
            await self._run(goal, parts, trajectories)
            fill_error(result.error_code, MoveItErrorCode.SUCCESS, '', SOURCE)
        self._server.end(goal, result.error_code.val)
        return result

    def _checked(self, parts: Sequence[SubTrajectory]) -> list[_Motion]:
        """
        Return the motions of all parts, of joints and of multi-DOF joints.

        :raises PlanningError: the first part that cannot be executed, and why.
        """
        trajectories = []
        for number, part in enumerate(parts):
            try:
                motion = robot_trajectory(self._context, part.trajectory)
                self._check(*motion, part.execution_info.controller_names)
            except PlanningError as error:
                raise _in_part(number, parts, error.code, str(error)) from None
            trajectories.append(motion)
        return trajectories

    def _check(
        self, trajectory: JointTrajectory, multi_dof: MultiDofTrajectory | None,
        names: Sequence[str],
    ) -> None:
        strangers = [name for name in trajectory.joint_names if name not in self._grouped
                     and not self._follows(name)]
        if strangers and len(trajectory):
            raise PlanningError(
                MoveItErrorCode.INVALID_MOTION_PLAN,
                f'no planning group has {", ".join(strangers)}; groups: '
                f'{", ".join(self._context.robot.semantic.groups) or "none"}')
        selected_controllers(
            self._context, self._execution.controllers, trajectory, names, multi_dof)

    def _follows(self, name: str) -> bool:
        """Return whether a joint follows others and cannot be commanded itself."""
        joint = self._context.robot.joints.get(name)
        return joint is not None and not joint.active

    async def _run(
        self, goal: ServerGoalHandle, parts: Sequence[SubTrajectory],
        trajectories: Sequence[_Motion]
    ) -> None:
        for number, (part, motion) in enumerate(zip(parts, trajectories, strict=True)):
            trajectory, multi_dof = motion
            path = PathWatch(
                self._context, trajectory.joint_names, partial(
                    self._execution.obstruction, trajectory))
            outcome = (await self._execution.queued(
                trajectory,
                ExecutionWatch(cancelled=lambda: goal.is_cancel_requested, invalid=path.invalid),
                part.execution_info.controller_names,
                multi_dof)).of_plan(cancelled=goal.is_cancel_requested)
            if not outcome.success:
                raise _in_part(number, parts, outcome.code, outcome.message)
            if goal.is_cancel_requested:
                raise _in_part(number, parts, MoveItErrorCode.PREEMPTED, 'cancelled by the client')
            goal.publish_feedback(SolutionAction.Feedback(sub_id=number, sub_no=len(parts)))
            if not await self._change_scene(number, part):
                raise _in_part(
                    number, parts, MoveItErrorCode.PREEMPTED,
                    'what it changes in the scene was refused, see the log of move_group')

    async def _change_scene(self, number: int, part: SubTrajectory) -> bool:
        """
        Apply what a part changes; where the joints are, the robot itself publishes.

        :returns: whether all of it was taken.
        """
        scene = part.scene_diff
        scene.robot_state.joint_state = JointState()
        scene.robot_state.multi_dof_joint_state = MultiDOFJointState()
        scene.robot_state.is_diff = True  # what is attached stays
        return is_empty(scene) or bool(
            await apply_scene_message(self._context, scene, f'{SOURCE}: part {number}'))


def _in_part(number: int, parts: Sequence[SubTrajectory], code: int, text: str) -> PlanningError:
    """Return an error that names the part by its number and its stage's comment."""
    comment = parts[number].info.comment
    name = f" ('{comment}')" if comment else ''
    return PlanningError(code, f'part {number} of {len(parts)}{name}: {text}', SOURCE)
