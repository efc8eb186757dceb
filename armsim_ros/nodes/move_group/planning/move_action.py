# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The action ``move_action``."""

from __future__ import annotations

from typing import Any

from moveit_msgs.action import MoveGroup as Action
from moveit_msgs.msg import RobotState
from rclpy.action.server import ServerGoalHandle

from armsim_ros.errors import MoveItErrorCode
from armsim_ros.nodes.conversions.motion_plan_request import (
    request_from_message,
    robot_trajectory_message,
)
from armsim_ros.nodes.conversions.planning_scene import is_empty
from armsim_ros.nodes.move_group.answers import fill_error, MoveGroupActionServer, reported
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.execution.execution import ExecutionOutcome
from armsim_ros.nodes.move_group.execution.path_watch import PathWatch, StateRecorder
from armsim_ros.nodes.move_group.execution.trajectory_execution import (
    execute_plan,
    TrajectoryExecutionManager,
)
from armsim_ros.nodes.move_group.planning.planning_job import (
    drop_robot_state,
    overlay,
    PlanningAnswer,
    PlanningJob,
)

DEFAULT_REPLANS = 5
PLAN_AGAIN = (
    MoveItErrorCode.PLANNING_FAILED,
    MoveItErrorCode.INVALID_MOTION_PLAN,
    MoveItErrorCode.UNABLE_TO_AQUIRE_SENSOR_DATA,
)


class MoveAction:
    """
    Plans and, unless plan_only is set, executes the plan.

    :param context: the parts of move_group.
    :param job: runs the planner.
    :param execution: sends trajectories to the controllers.
    :param name: of the action.
    """

    def __init__(
        self,
        context: Context,
        job: PlanningJob,
        execution: TrajectoryExecutionManager,
        *,
        name: str = 'move_action',
    ) -> None:
        self._context = context
        self._job = job
        self._execution = execution
        self._server = MoveGroupActionServer(context, Action, name, self._execute)

    async def _execute(self, goal: ServerGoalHandle) -> Any:
        result = Action.Result()
        fill_error(result.error_code, MoveItErrorCode.FAILURE, 'not planned', 'move_action')
        with reported(self._context.logger, 'move_action', result.error_code):
            if plans_only(
                self._context, 'move_action', requested=goal.request.planning_options.plan_only
            ):
                plan = await self._plan(goal, goal.request.request)
                fill_plan(result, plan)
            else:
                await self._plan_and_execute(goal, result)
        goal.publish_feedback(Action.Feedback(state='IDLE'))
        self._server.end(goal, result.error_code.val)
        return result

    async def _plan(self, goal: ServerGoalHandle, request: Any) -> PlanningAnswer:
        goal.publish_feedback(Action.Feedback(state='PLANNING'))
        return await self._job.run(
            request,
            scene_diff=goal.request.planning_options.planning_scene_diff,
            cancelled=lambda: goal.is_cancel_requested,
        )

    async def _plan_and_execute(self, goal: ServerGoalHandle, result: Any) -> None:
        options, request = goal.request.planning_options, goal.request.request
        unchanged = is_empty(options.planning_scene_diff)
        if unchanged and await self._already_there(goal):
            fill_error(result.error_code, MoveItErrorCode.SUCCESS, 'the robot is at the goal')
            return
        state, warn = request.start_state, self._context.logger.warning
        if state.joint_state.name or state.attached_collision_objects:
            warn('move_action: the start state is ignored, a motion begins where the robot is')
        request.start_state = RobotState(is_diff=True)
        drop_robot_state(options.planning_scene_diff, warn, 'move_action')
        attempts = max(options.replan_attempts, 0) or DEFAULT_REPLANS if options.replan else 1
        for attempt in range(1, attempts + 1):
            if goal.is_cancel_requested:
                fill_error(result.error_code, MoveItErrorCode.PREEMPTED, 'cancelled', 'planning')
                return
            plan = await self._plan(goal, request)
            fill_plan(result, plan)
            if not plan.response.success:
                if plan.response.error_code in PLAN_AGAIN and attempt < attempts:
                    continue
                return
            recorder = StateRecorder(self._context, plan.response.trajectory.joint_names)
            outcome = await self._run(goal, plan, recorder)
            result.executed_trajectory = robot_trajectory_message(
                recorder.trajectory, self._context.frame
            )
            fill_error(result.error_code, outcome.code, outcome.message, 'execution')
            if outcome.success:
                return
            self._context.logger.error(f'move_action: {outcome.message}')
            changed = MoveItErrorCode.MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE
            if outcome.code != changed or attempt == attempts:
                return
            await self._pause(goal, options.replan_delay)

    async def _already_there(self, goal: ServerGoalHandle) -> bool:
        scene = await self._job.scene()
        request = request_from_message(goal.request.request)
        context = self._context
        return bool(
            await context.queries.submit(
                lambda: context.query_planner.goal_reached(request, scene)
            )
        )

    async def _run(
        self, goal: ServerGoalHandle, plan: PlanningAnswer, recorder: StateRecorder
    ) -> ExecutionOutcome:
        if goal.is_cancel_requested:
            return ExecutionOutcome(MoveItErrorCode.PREEMPTED, 'cancelled before it moved')
        goal.publish_feedback(Action.Feedback(state='MONITOR'))
        trajectory, options = plan.response.trajectory, goal.request.planning_options
        path = PathWatch(
            self._context, trajectory, plan.request.group_name,
            lambda scene: overlay(scene, options.planning_scene_diff))
        return await execute_plan(
            self._execution, trajectory, path, lambda: goal.is_cancel_requested, recorder.note)

    async def _pause(self, goal: ServerGoalHandle, seconds: float) -> None:
        end = self._context.clock() + min(max(seconds, 0.0), 60.0)
        while self._context.clock() < end and not goal.is_cancel_requested:
            await self._context.ticker.next()


def plans_only(context: Context, source: str, *, requested: bool) -> bool:
    """Return whether a goal is only planned: on request, or because execution is off."""
    if not requested and not context.execution_settings.allow_trajectory_execution:
        context.logger.warning(
            f'{source}: trajectory execution is switched off (allow_trajectory_execution is '
            'false); planning only'
        )
        return True
    return requested


def fill_plan(result: Any, plan: PlanningAnswer) -> None:
    """Write a plan into an action result."""
    result.trajectory_start = plan.start_message
    result.planned_trajectory = plan.trajectory_message
    result.planning_time = plan.response.planning_time
    result.error_code = plan.error_code_message
