# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The services ``plan_kinematic_path``, ``plan_sequence_path`` and ``compute_cartesian_path``."""

from __future__ import annotations

from moveit_msgs.msg import MotionSequenceRequest
from moveit_msgs.srv import GetCartesianPath, GetMotionPlan, GetMotionSequence

from armsim_ros.errors import MoveItErrorCode
from armsim_ros.nodes.conversions.geometry import pose_from_message
from armsim_ros.nodes.conversions.motion_plan_request import (
    constraints_from_message,
    robot_state_to_message,
    robot_trajectory_message,
    start_state_from_message,
)
from armsim_ros.nodes.move_group.context import Context, fill_error
from armsim_ros.nodes.move_group.planning.move_actions import SequenceJob
from armsim_ros.nodes.move_group.planning.planner_services import DisplayPlannedPath
from armsim_ros.nodes.move_group.planning.planning_job import PlanningJob, response_message
from armsim_ros.planning.request import CartesianRequest


class PlanKinematicPath:
    """Plans and never moves."""

    def __init__(self, context: Context, job: PlanningJob) -> None:
        self._context, self._job = context, job
        context.serve(GetMotionPlan, 'plan_kinematic_path', self._fill,
                      lambda response: response.motion_plan_response.error_code)

    async def _fill(
        self, request: GetMotionPlan.Request, response: GetMotionPlan.Response
    ) -> None:
        plan = await self._job.run(request.motion_plan_request)
        response.motion_plan_response = response_message(plan)


class PlanSequencePath:
    """Plans sequences of motions in the default pipeline and never moves."""

    def __init__(self, context: Context, job: SequenceJob) -> None:
        self._context, self._job = context, job
        context.serve(GetMotionSequence, 'plan_sequence_path', self._fill,
                      lambda response: response.response.error_code)

    async def _fill(
        self, request: GetMotionSequence.Request, response: GetMotionSequence.Response
    ) -> None:
        await self._job.run(
            request.request, response.response, pipeline=self._pipeline(request.request))

    def _pipeline(self, request: MotionSequenceRequest) -> str:
        """Return the default pipeline; an unknown pipeline of the first motion stays."""
        default = self._context.pipeline_of('')
        requested = request.items[0].req.pipeline_id if request.items else ''
        if not requested or requested == default:
            return default
        if requested not in self._context.planning_parameters.planning_pipelines:
            return requested
        self._context.logger.warning(
            f"plan_sequence_path plans in the default pipeline '{default}' and not in "
            f"'{requested}', which the first motion names; use the action sequence_move_group "
            'with plan_only, or set default_planning_pipeline')
        return default


class ComputeCartesianPath:
    """Follows straight lines between poses as far as possible."""

    def __init__(self, context: Context, job: PlanningJob, display: DisplayPlannedPath) -> None:
        self._context, self._job, self._display = context, job, display
        context.serve(GetCartesianPath, 'compute_cartesian_path', self._fill,
                      lambda response: response.error_code)

    async def _fill(
        self, request: GetCartesianPath.Request, response: GetCartesianPath.Response
    ) -> None:
        context = self._context
        scene = await self._job.scene(request.start_state)
        requested = CartesianRequest(
            group_name=request.group_name,
            waypoints=tuple(pose_from_message(pose) for pose in request.waypoints),
            link_name=request.link_name, start_state=start_state_from_message(request.start_state),
            max_step=float(request.max_step), avoid_collisions=bool(request.avoid_collisions),
            path_constraints=constraints_from_message(request.path_constraints),
            max_velocity_scaling_factor=float(request.max_velocity_scaling_factor),
            max_acceleration_scaling_factor=float(request.max_acceleration_scaling_factor),
            cartesian_speed_limited_link=request.cartesian_speed_limited_link,
            max_cartesian_speed=float(request.max_cartesian_speed),
            frame_id=request.header.frame_id)
        answer = await context.planning.submit(
            lambda: context.planner.cartesian_path(requested, scene))
        fill_error(response.error_code, answer.error_code, answer.message, answer.source)
        if answer.error_code != MoveItErrorCode.SUCCESS:
            return
        response.fraction = float(answer.fraction)
        if not len(answer.trajectory):
            return
        carried = context.started(scene, requested.start_state).attached.values()
        response.start_state = robot_state_to_message(
            answer.start, context.frame, attached=carried)
        response.solution = robot_trajectory_message(answer.trajectory, context.frame)
        self._display.publish(response.start_state, response.solution)
