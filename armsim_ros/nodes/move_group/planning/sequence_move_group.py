# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Sequences of motions: planned, and as the action ``sequence_move_group``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from moveit_msgs.action import MoveGroupSequence as Action
from moveit_msgs.msg import MotionSequenceRequest, MotionSequenceResponse
from moveit_msgs.msg import PlanningScene as SceneMessage
from rclpy.action.server import ServerGoalHandle

from armsim_ros.errors import MoveItErrorCode
from armsim_ros.nodes.conversions.motion_plan_request import (
    request_from_message,
    robot_state_to_message,
    robot_trajectory_message,
)
from armsim_ros.nodes.move_group.answers import fill_error, MoveGroupActionServer, reported
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.execution.path_watch import PathWatch
from armsim_ros.nodes.move_group.execution.trajectory_execution import (
    execute_plan,
    TrajectoryExecutionManager,
)
from armsim_ros.nodes.move_group.planning.display import DisplayPlannedPath
from armsim_ros.nodes.move_group.planning.move_action import plans_only
from armsim_ros.nodes.move_group.planning.planning_job import (
    drop_robot_state,
    log_refused,
    overlay,
    PlanningJob,
)
from armsim_ros.planning.pilz.sequence import SequenceItem, SequenceResponse
from armsim_ros.planning.planner import never


class SequenceJob:
    """
    Plans sequences in the planner's worker.

    :param context: the parts of move_group.
    :param job: knows the present state.
    :param display: gets every trajectory of a successful plan.
    """

    def __init__(self, context: Context, job: PlanningJob, display: DisplayPlannedPath) -> None:
        self._context = context
        self._job = job
        self._display = display

    async def run(
        self,
        message: MotionSequenceRequest,
        answer: MotionSequenceResponse,
        *,
        scene_diff: SceneMessage | None = None,
        cancelled: Callable[[], bool] = never,
        pipeline: str = '',
    ) -> SequenceResponse:
        """
        Plan, fill the answer, and return it as values too.

        :param pipeline: plans all motions; '' for the pipeline of the first.
        :raises PlanningError: the message holds what cannot exist, or no state ever came.
        """
        items = [
            SequenceItem(request_from_message(item.req), float(item.blend_radius))
            for item in message.items
        ]
        context = self._context
        cancelled = context.or_ending(cancelled)
        scene = await (self._job.scene() if items else context.present_scene())
        if scene_diff is not None:
            scene = overlay(scene, scene_diff)
            log_refused(scene, context.logger)
        response: SequenceResponse = await self._job.in_planner(
            lambda: context.planner.plan_sequence(
                items, scene, clock=context.planning_clock(), cancelled=cancelled,
                pipeline=pipeline,
            ),
            cancelled,
        )
        context.check_ending('planning')
        answer.planning_time = response.planning_time
        fill_error(
            answer.error_code, response.error_code, response.message, response.source
        )
        starts = []
        if response.start:
            carried = context.started(scene, items[0].request.start_state).attached.values()
            starts = [
                robot_state_to_message(plan.trajectory_start, context.frame, attached=carried)
                for plan in response.plans
            ]
            answer.sequence_start = starts[0]
        answer.planned_trajectories = [
            robot_trajectory_message(trajectory, context.frame)
            for trajectory in response.trajectories
        ]
        for plan, start in zip(response.plans, starts, strict=True):
            self._display.publish_plan(
                pipeline or items[0].request.pipeline_id
                or context.planning_parameters.default_planning_pipeline,
                start, robot_trajectory_message(plan.trajectory, context.frame))
        return response


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
