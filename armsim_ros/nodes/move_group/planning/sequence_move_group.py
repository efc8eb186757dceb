# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The action ``sequence_move_group``."""

from __future__ import annotations

from typing import Any

from moveit_msgs.action import MoveGroupSequence as Action
from rclpy.action.server import ServerGoalHandle

from armsim_ros.errors import MoveItErrorCode
from armsim_ros.nodes.move_group.action_server import MoveGroupActionServer
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.execution.path_watch import PathWatch
from armsim_ros.nodes.move_group.execution.trajectory_execution import (
    execute_plan,
    TrajectoryExecutionManager,
)
from armsim_ros.nodes.move_group.failures import fill_error, reported
from armsim_ros.nodes.move_group.planning.move_action import plans_only
from armsim_ros.nodes.move_group.planning.planning_job import drop_robot_state, overlay
from armsim_ros.nodes.move_group.planning.sequence_job import SequenceJob
from armsim_ros.planning.pilz.sequence import SequenceResponse

SOURCE = 'sequence_move_group'


class SequenceMoveGroup:
    """
    Plans sequences of motions and, unless plan_only is set, executes them.

    :param context: the parts of move_group.
    :param job: runs the planner.
    :param execution: sends trajectories to the controllers.
    """

    def __init__(
        self, context: Context, job: SequenceJob, execution: TrajectoryExecutionManager
    ) -> None:
        self._context = context
        self._job = job
        self._execution = execution
        self._server = MoveGroupActionServer(context, Action, SOURCE, self._execute)

    async def _execute(self, goal: ServerGoalHandle) -> Any:
        result, options = Action.Result(), goal.request.planning_options
        code = result.response.error_code
        fill_error(code, MoveItErrorCode.FAILURE, 'not planned', SOURCE)
        goal.publish_feedback(Action.Feedback(state='PLANNING'))
        with reported(self._context.logger, SOURCE, code):
            plan_only = plans_only(self._context, SOURCE, requested=options.plan_only)
            if not plan_only:
                drop_robot_state(
                    options.planning_scene_diff, self._context.logger.warning, SOURCE)
            plan = await self._job.run(
                goal.request.request,
                result.response,
                scene_diff=options.planning_scene_diff,
                cancelled=lambda: goal.is_cancel_requested,
            )
            if code.val == MoveItErrorCode.SUCCESS and not plan_only:
                await self._run(goal, plan, code)
        goal.publish_feedback(Action.Feedback(state='IDLE'))
        self._server.end(goal, code.val)
        return result

    async def _run(self, goal: ServerGoalHandle, plan: SequenceResponse, code: Any) -> None:
        goal.publish_feedback(Action.Feedback(state='MONITOR'))
        diff = goal.request.planning_options.planning_scene_diff
        for trajectory, request in zip(plan.trajectories, plan.requests, strict=True):
            path = PathWatch(
                self._context, trajectory, request.group_name, lambda scene: overlay(scene, diff))
            outcome = await execute_plan(
                self._execution, trajectory, path, lambda: goal.is_cancel_requested)
            if not outcome.success:
                fill_error(code, outcome.code, outcome.message, 'execution')
                self._context.logger.error(f'{SOURCE}: {outcome.message}')
                return
