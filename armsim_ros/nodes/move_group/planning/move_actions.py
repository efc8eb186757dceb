# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The actions ``move_action`` and ``sequence_move_group``."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import replace
from typing import Any, TypeVar

from moveit_msgs.action import MoveGroup, MoveGroupSequence
from moveit_msgs.msg import (
    MotionSequenceRequest,
    MotionSequenceResponse,
    MoveItErrorCodes,
    RobotState,
)
from moveit_msgs.msg import PlanningScene as SceneMessage
from rclpy.action.server import ServerGoalHandle

from armsim_ros.errors import MoveItErrorCode
from armsim_ros.nodes.conversions.motion_plan_request import (
    request_from_message,
    robot_trajectory_message,
)
from armsim_ros.nodes.conversions.planning_scene import is_empty
from armsim_ros.nodes.move_group.context import (
    Context,
    fill_error,
    MoveGroupActionServer,
    reported,
)
from armsim_ros.nodes.move_group.execution.execution import ExecutionOutcome, ExecutionWatch
from armsim_ros.nodes.move_group.execution.trajectory_execution import (
    PathWatch,
    TrajectoryExecutionManager,
)
from armsim_ros.nodes.move_group.execution.trajectory_monitor import TrajectoryMonitor
from armsim_ros.nodes.move_group.planning.planning_job import (
    drop_robot_state,
    log_refused,
    overlay,
    PlanningAnswer,
    PlanningJob,
)
from armsim_ros.planning.pilz.sequence import SequenceItem, SequenceResponse
from armsim_ros.planning.planner import never
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.trajectory import JointTrajectory

DEFAULT_REPLANS = 5
PLAN_AGAIN = (
    MoveItErrorCode.PLANNING_FAILED, MoveItErrorCode.INVALID_MOTION_PLAN,
    MoveItErrorCode.UNABLE_TO_AQUIRE_SENSOR_DATA)


Plan = TypeVar('Plan')


async def plan_and_execute(
    context: Context, source: str, goal: ServerGoalHandle, code: MoveItErrorCodes,
    plan: Callable[[], Awaitable[Plan]], execute: Callable[[Plan], Awaitable[ExecutionOutcome]],
) -> None:
    """
    Plan and execute, again as often as the planning options of a goal allow.

    :param source: name of the action.
    :param code: where the outcome is written.
    :param plan: makes a plan and writes its outcome into the code.
    """
    options = goal.request.planning_options
    attempts = max(options.replan_attempts, 0) or DEFAULT_REPLANS if options.replan else 1
    for attempt in range(1, attempts + 1):
        if goal.is_cancel_requested:
            fill_error(code, MoveItErrorCode.PREEMPTED, 'cancelled', 'planning')
            return
        made = await plan()
        if goal.is_cancel_requested:
            # Whatever planning has returned.
            fill_error(code, MoveItErrorCode.PREEMPTED, 'cancelled before it moved', 'planning')
            return
        if code.val in PLAN_AGAIN:
            continue
        if code.val != MoveItErrorCode.SUCCESS:
            return
        outcome = await execute(made)
        fill_error(code, outcome.code, outcome.message, 'execution')
        if outcome.success:
            return
        context.logger.error(f'{source}: {outcome.message}')
        changed = MoveItErrorCode.MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE
        if outcome.code != changed or attempt == attempts:
            return
        end = context.clock() + min(max(options.replan_delay, 0.0), 60.0)
        given_up = context.or_ending(lambda: goal.is_cancel_requested)
        while context.clock() < end and not given_up():
            await context.ticker.next()


async def execute_watched(
    context: Context, execution: TrajectoryExecutionManager, goal: ServerGoalHandle,
    trajectory: JointTrajectory, group: str, planned_in: PlanningScene,
) -> ExecutionOutcome:
    """
    Execute a plan of a goal while nothing comes into its way.

    As in MoveIt, links are not padded, path constraints are not checked, and the goal's own
    changes of the scene count.

    :param group: planning group that it moves.
    :param planned_in: the monitored scene as it was when the plan was begun.
    """
    diff = goal.request.planning_options.planning_scene_diff

    def fault(elapsed: float, scene: PlanningScene) -> str:
        return context.query_planner.path_fault(trajectory, elapsed, overlay(scene, diff), group)

    path = PathWatch(context, trajectory.joint_names, fault, planned_in)
    outcome = await execution.run(trajectory, ExecutionWatch(
        cancelled=lambda: goal.is_cancel_requested, invalid=path.invalid))
    return outcome.of_plan(cancelled=goal.is_cancel_requested)


class MoveAction:
    """
    Plans and, unless plan_only is set, executes the plan.

    :param name: of the action.
    """

    def __init__(
        self, context: Context, job: PlanningJob, execution: TrajectoryExecutionManager, *,
        name: str = 'move_action'
    ) -> None:
        self._context, self._job, self._execution = context, job, execution
        self._server = MoveGroupActionServer(context, MoveGroup, name, self._execute)

    async def _execute(self, goal: ServerGoalHandle) -> Any:
        result = MoveGroup.Result()
        fill_error(result.error_code, MoveItErrorCode.FAILURE, 'not planned', 'move_action')
        with reported(self._context.logger, 'move_action', result.error_code):
            if plans_only(
                self._context, 'move_action', requested=goal.request.planning_options.plan_only
            ):
                await self._plan(goal, result)
            else:
                await self._plan_and_execute(goal, result)
        goal.publish_feedback(MoveGroup.Feedback(state='IDLE'))
        self._server.end(goal, result.error_code.val)
        return result

    async def _plan(self, goal: ServerGoalHandle, result: Any) -> PlanningAnswer:
        goal.publish_feedback(MoveGroup.Feedback(state='PLANNING'))
        plan = await self._job.run(
            goal.request.request,
            scene_diff=goal.request.planning_options.planning_scene_diff,
            cancelled=lambda: goal.is_cancel_requested)
        result.trajectory_start = plan.start_message
        result.planned_trajectory = plan.trajectory_message
        response = plan.response
        result.planning_time = response.planning_time
        fill_error(result.error_code, response.error_code, response.message, response.source)
        return plan

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

        async def execute(plan: PlanningAnswer) -> ExecutionOutcome:
            goal.publish_feedback(MoveGroup.Feedback(state='MONITOR'))
            context = self._context
            with TrajectoryMonitor(
                    context.states, context.robot, context.record_frequency) as monitor:
                outcome = await execute_watched(
                    context, self._execution, goal, plan.response.trajectory,
                    plan.request.group_name, plan.planned_in)
            result.executed_trajectory = robot_trajectory_message(
                monitor.trajectory, context.frame)
            return outcome

        await plan_and_execute(
            self._context, 'move_action', goal, result.error_code,
            lambda: self._plan(goal, result), execute)

    async def _already_there(self, goal: ServerGoalHandle) -> bool:
        scene = await self._job.scene()
        request = request_from_message(goal.request.request)
        context = self._context
        return bool(
            await context.queries.submit(
                lambda: context.query_planner.goal_reached(request, scene)))


def plans_only(context: Context, source: str, *, requested: bool) -> bool:
    """Return whether a goal is only planned: on request, or because execution is off."""
    if not requested and not context.execution_settings.allow_trajectory_execution:
        context.logger.warning(
            f'{source}: trajectory execution is switched off (allow_trajectory_execution is '
            'false); planning only')
        return True
    return requested


class SequenceJob:
    """Plans sequences in the planner's worker."""

    def __init__(self, context: Context, job: PlanningJob) -> None:
        self._context, self._job = context, job

    async def run(
        self, message: MotionSequenceRequest, answer: MotionSequenceResponse, *,
        scene_diff: SceneMessage | None = None, cancelled: Callable[[], bool] = never,
        pipeline: str = ''
    ) -> tuple[SequenceResponse, PlanningScene]:
        """
        Plan, fill the answer, and return it as values too, with the scene before any difference.

        :param pipeline: plans all motions; '' for the pipeline of the first.
        :raises PlanningError: the message holds what cannot exist, or no state ever came.
        """
        items = [
            SequenceItem(request_from_message(item.req), float(item.blend_radius))
            for item in message.items]
        context = self._context
        cancelled = context.or_ending(cancelled)
        scene = planned_in = await (
            self._job.scene() if items else context.present_scene())
        if scene_diff is not None:
            scene = overlay(scene, scene_diff)
            log_refused(scene, context.logger)
        response: SequenceResponse = await self._job.in_planner(
            lambda: context.planner.plan_sequence(
                items, scene, clock=context.planning_clock(), cancelled=cancelled,
                pipeline=pipeline),
            cancelled)
        context.check_ending('planning')
        answer.planning_time = response.planning_time
        fill_error(answer.error_code, response.error_code, response.message, response.source)
        answer.planned_trajectories = [
            robot_trajectory_message(trajectory, context.frame)
            for trajectory in response.trajectories]
        for number, (item, made) in enumerate(zip(items, response.plans, strict=False)):
            # All motions carry what the first carries.
            request = replace(item.request, start_state=items[0].request.start_state)
            plan = self._job.in_messages(request, made, scene, planned_in)
            name = context.pipeline_of(pipeline or items[0].request.pipeline_id)
            self._job.topics.begin(name, message.items[number].req)
            self._job.topics.end(name, message.items[number].req, plan)
            if response.trajectories and not number:
                answer.sequence_start = plan.start_message
        return response, planned_in


SOURCE = 'sequence_move_group'


class SequenceMoveGroup:
    """Plans sequences of motions and, unless plan_only is set, executes them."""

    def __init__(
        self, context: Context, job: SequenceJob, execution: TrajectoryExecutionManager
    ) -> None:
        self._context, self._job, self._execution = context, job, execution
        self._server = MoveGroupActionServer(context, MoveGroupSequence, SOURCE, self._execute)

    async def _execute(self, goal: ServerGoalHandle) -> Any:
        result, options = MoveGroupSequence.Result(), goal.request.planning_options
        code, context = result.response.error_code, self._context
        fill_error(code, MoveItErrorCode.FAILURE, 'not planned', SOURCE)
        with reported(context.logger, SOURCE, code):
            if plans_only(context, SOURCE, requested=options.plan_only):
                await self._plan(goal, result)
            else:
                drop_robot_state(options.planning_scene_diff, context.logger.warning, SOURCE)
                await plan_and_execute(
                    context, SOURCE, goal, code, lambda: self._plan(goal, result),
                    lambda plan: self._run(goal, *plan))
        goal.publish_feedback(MoveGroupSequence.Feedback(state='IDLE'))
        self._server.end(goal, code.val)
        return result

    async def _plan(
        self, goal: ServerGoalHandle, result: Any
    ) -> tuple[SequenceResponse, PlanningScene]:
        goal.publish_feedback(MoveGroupSequence.Feedback(state='PLANNING'))
        return await self._job.run(
            goal.request.request, result.response,
            scene_diff=goal.request.planning_options.planning_scene_diff,
            cancelled=lambda: goal.is_cancel_requested)

    async def _run(
        self, goal: ServerGoalHandle, plan: SequenceResponse, planned_in: PlanningScene
    ) -> ExecutionOutcome:
        goal.publish_feedback(MoveGroupSequence.Feedback(state='MONITOR'))
        for trajectory, request in zip(plan.trajectories, plan.requests, strict=True):
            outcome = await execute_watched(
                self._context, self._execution, goal, trajectory, request.group_name, planned_in)
            if not outcome.success:
                return outcome
        return ExecutionOutcome(MoveItErrorCode.SUCCESS)
