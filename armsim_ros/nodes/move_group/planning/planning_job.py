# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A planning request from its message to an answer in messages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from moveit_msgs.msg import MotionPlanRequest as RequestMessage
from moveit_msgs.msg import MotionPlanResponse as ResponseMessage
from moveit_msgs.msg import MoveItErrorCodes, PipelineState, RobotState, RobotTrajectory
from moveit_msgs.msg import PlanningScene as SceneMessage
from rclpy.node import Node

from armsim_ros.config.ompl_planning import PipelineSettings
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.nodes.conversions.motion_plan_request import (
    error_code_message,
    request_from_message,
    robot_state_to_message,
    robot_trajectory_message,
)
from armsim_ros.nodes.conversions.planning_scene import update_from_message
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.planning.planner_services import (
    DisplayContacts,
    DisplayPlannedPath,
    without_package,
)
from armsim_ros.nodes.move_group.worker import AnyOf
from armsim_ros.planning.planner import never
from armsim_ros.planning.request import MotionPlanRequest, MotionPlanResponse
from armsim_ros.planning.scene.planning_scene import PlanningScene

DEPTH = 20


class PipelineStates:
    """
    Publishes the stages of a plan: an empty stage when it begins, all others when it is complete.

    The planner answers once, with the stage that refused the request, so all that it passed are
    published together. Nothing is composed without subscribers.

    :param settings: the planner, the adapters and the topic's name; '' publishes nothing.
    """

    def __init__(self, node: Node, settings: PipelineSettings) -> None:
        self._settings = settings
        self._publisher = None
        if settings.progress_topic:
            self._publisher = node.create_publisher(PipelineState, settings.progress_topic, DEPTH)

    def begin(self, request: RequestMessage) -> None:
        """Publish that work on a request has begun."""
        self._publish(request, ResponseMessage(), '')

    def end(self, request: RequestMessage, response: ResponseMessage) -> None:
        """
        Publish each stage that a request has passed, and the stage that refused it.

        :param response: its error code names the stage.
        """
        if not self._heard:
            return
        success = response.error_code.val == MoveItErrorCodes.SUCCESS
        passed = ResponseMessage()
        passed.error_code.val = MoveItErrorCodes.SUCCESS
        before = without_package(self._settings.used_request_adapters)
        after = without_package(self._settings.used_response_adapters)
        planned = len(before)
        stages = [*before, self._planner, *after]
        last = len(stages) - 1
        if not success:
            source = response.error_code.source
            last = stages.index(source) if source in stages else planned
        for place, stage in enumerate(stages[: last + 1]):
            ends = success and place >= planned
            self._publish(request, response if ends or place == last else passed, stage)

    @property
    def _heard(self) -> bool:
        return self._publisher is not None and self._publisher.get_subscription_count() > 0

    def _publish(self, request: RequestMessage, response: ResponseMessage, stage: str) -> None:
        if self._publisher is not None and self._heard:
            self._publisher.publish(
                PipelineState(request=request, response=response, pipeline_stage=stage))

    @property
    def _planner(self) -> str:
        return '' if self._settings.planner is None else self._settings.planner.value


@dataclass(frozen=True, eq=False)
class PlanningAnswer:
    """
    A planner's answer with its messages.

    :param scene: that of the plan.
    :param planned_in: the same without the request's own changes.
    """

    request: MotionPlanRequest
    response: MotionPlanResponse
    scene: PlanningScene
    planned_in: PlanningScene
    start_message: RobotState
    trajectory_message: RobotTrajectory

    @property
    def error_code_message(self) -> MoveItErrorCodes:
        """The answer's code, sentence and source."""
        answer = self.response
        return error_code_message(answer.error_code, answer.message, answer.source)


class PlanTopics:
    """
    Publishes about each plan what its pipeline publishes: stages, the path, contacts.

    Requests for a pipeline that does not exist have no stages.
    """

    def __init__(self, context: Context, display: DisplayPlannedPath) -> None:
        self._display = display
        self._states: dict[str, PipelineStates] = {}
        self._contacts: dict[str, DisplayContacts] = {}
        topics: dict[str, DisplayContacts] = {}
        for name, settings in context.pipelines.items():
            self._states[name] = PipelineStates(context.node, settings)
            topic = settings.display_contacts_topic
            if topic not in topics:
                topics[topic] = DisplayContacts(context.node, topic, context.frame)
            self._contacts[name] = topics[topic]

    def begin(self, pipeline: str, request: RequestMessage) -> None:
        """Publish that work on a request has begun."""
        if pipeline in self._states:
            self._states[pipeline].begin(request)

    def end(self, pipeline: str, request: RequestMessage, plan: PlanningAnswer) -> None:
        """Publish how planning has ended."""
        if pipeline not in self._states:
            return
        response = plan.response
        if response.success:
            self._display.publish_plan(pipeline, plan.start_message, plan.trajectory_message)
        if response.contacts or response.source == 'ValidateSolution':
            self._contacts[pipeline].publish(response.contacts)
        self._states[pipeline].end(request, response_message(plan))


class PlanningJob:
    """
    Runs the planner in its worker.

    :param topics: get what is published of each plan.
    """

    def __init__(self, context: Context, topics: PlanTopics) -> None:
        self._context, self.topics = context, topics

    async def run(
        self, message: RequestMessage, *, scene: PlanningScene | None = None,
        scene_diff: SceneMessage | None = None, cancelled: Callable[[], bool] = never
    ) -> PlanningAnswer:
        """
        Plan and answer.

        :param scene: to plan in; None for the monitored scene.
        :param scene_diff: laid over the scene for this request alone.
        :param cancelled: asked now and then while the planner searches.
        :raises PlanningError: the message holds what cannot exist, or no state ever came.
        """
        context = self._context
        request = request_from_message(message)
        pipeline = context.pipeline_of(request.pipeline_id)
        self.topics.begin(pipeline, message)
        if scene is None:
            scene = await self.scene(message.start_state)
        planned_in = scene
        if scene_diff is not None:
            scene = overlay(scene, scene_diff)
            log_refused(scene, context.logger)
        planner, clock = context.planner, context.planning_clock()
        cancelled = context.or_ending(cancelled)
        response = await self.in_planner(
            lambda: planner.plan(request, scene, clock=clock, cancelled=cancelled), cancelled)
        context.check_ending('planning')
        plan = self.in_messages(request, response, scene, planned_in)
        self.topics.end(pipeline, message, plan)
        return plan

    async def in_planner(self, work: Callable[[], Any], cancelled: Callable[[], bool]) -> Any:
        """
        Queue work for the planner's worker and wait for it.

        :raises PlanningError: PREEMPTED where it was cancelled while it waited for that.
        """
        job = self._context.planning.submit(work)
        while not job.done():
            if not job.begun and cancelled():
                job.cancel()
                self._context.check_ending('planning')
                raise PlanningError(
                    MoveItErrorCode.PREEMPTED, 'cancelled before its planning began', 'planning')
            await AnyOf(job, self._context.ticker.next())
        return job.result()

    async def scene(self, start: RobotState | None = None) -> PlanningScene:
        """
        Return the scene to plan in.

        :param start: of the request; a start that names all joints needs no present state.
        :raises PlanningError: no joint state ever came.
        """
        if start is None or start.is_diff or not start.joint_state.name:
            await self._current_state()
        return await self._context.present_scene()

    async def _current_state(self) -> None:
        """
        Bring the scene to the present.

        :raises PlanningError: no joint state ever came, or the program ends.
        """
        context = self._context
        if await context.states.current():
            return
        context.check_ending('joint_states')
        topics = ', '.join(context.states.topics)
        if context.states.count == 0:
            raise PlanningError(
                MoveItErrorCode.ROBOT_STATE_STALE,
                f'no joint state has arrived on {topics}; is the simulation running?',
                'joint_states')
        context.logger.warning(
            f'no joint state newer than the request within 1 s on {topics}; using the last')

    def in_messages(
        self, request: MotionPlanRequest, response: MotionPlanResponse, scene: PlanningScene,
        planned_in: PlanningScene,
    ) -> PlanningAnswer:
        """
        Return an answer with its messages.

        :param scene: that of the plan.
        :param planned_in: the same without the request's own changes.
        """
        frame = self._context.frame
        trajectory, start = RobotTrajectory(), RobotState()
        if response.success:
            carried: Any = self._context.started(scene, request.start_state).attached.values()
            trajectory = robot_trajectory_message(response.trajectory, frame)
            start = robot_state_to_message(response.trajectory_start, frame, attached=carried)
        return PlanningAnswer(request, response, scene, planned_in, start, trajectory)


def response_message(plan: PlanningAnswer) -> ResponseMessage:
    """Return the message of an answer."""
    return ResponseMessage(
        trajectory_start=plan.start_message, trajectory=plan.trajectory_message,
        group_name=plan.request.group_name, planning_time=plan.response.planning_time,
        error_code=plan.error_code_message)


def log_refused(scene: PlanningScene, logger: Any) -> None:
    """Log what of a request's scene difference or robot state was refused."""
    if scene.refused:
        logger.warning(f'planning scene: {scene.refused}')


def overlay(scene: PlanningScene, message: SceneMessage) -> PlanningScene:
    """
    Return a scene with a request's own changes.

    :param message: a difference, whatever its ``is_diff`` is.
    """
    update = update_from_message(message, scene.model_frame)
    return scene.with_update(replace(update, is_diff=True))


def drop_robot_state(message: SceneMessage, warn: Callable[[str], object], source: str) -> None:
    """Take the robot state out of a scene difference: a motion is executed from the present."""
    state = message.robot_state
    if state.joint_state.name or state.attached_collision_objects:
        warn(f'{source}: the robot state of planning_scene_diff is ignored, a motion is executed '
             'from the present state of the robot with its attached objects')
    message.robot_state = RobotState(is_diff=True)
