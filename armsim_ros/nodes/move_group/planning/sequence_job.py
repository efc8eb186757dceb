# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A request for a sequence of motions, from its message to an answer in messages."""

from __future__ import annotations

from collections.abc import Callable

from moveit_msgs.msg import MotionSequenceRequest, MotionSequenceResponse
from moveit_msgs.msg import PlanningScene as SceneMessage

from armsim_ros.nodes.conversions.motion_plan_request import (
    request_from_message,
    robot_trajectory_message,
)
from armsim_ros.nodes.conversions.robot_state import robot_state_to_message
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.failures import fill_error
from armsim_ros.nodes.move_group.planning.display import DisplayPlannedPath
from armsim_ros.nodes.move_group.planning.planning_job import (
    log_refused,
    never,
    overlay,
    PlanningJob,
)
from armsim_ros.planning.pilz.sequence import SequenceItem, SequenceResponse


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
