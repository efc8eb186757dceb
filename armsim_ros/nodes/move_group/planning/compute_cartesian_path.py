# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The service ``compute_cartesian_path``."""

from __future__ import annotations

from moveit_msgs.srv import GetCartesianPath as Service

from armsim_ros.errors import MoveItErrorCode
from armsim_ros.nodes.conversions.constraints import constraints_from_message
from armsim_ros.nodes.conversions.geometry import pose_from_message
from armsim_ros.nodes.conversions.motion_plan_request import robot_trajectory_message
from armsim_ros.nodes.conversions.robot_state import (
    robot_state_to_message,
    start_state_from_message,
)
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.failures import fill_error, reported
from armsim_ros.nodes.move_group.planning.display_planned_path import DisplayPlannedPath
from armsim_ros.nodes.move_group.planning.planning_job import PlanningJob
from armsim_ros.planning.request import CartesianRequest


class ComputeCartesianPath:
    """
    Follows straight lines between poses as far as possible.

    :param context: the parts of move_group.
    :param job: brings the scene to the present.
    :param display: gets every path.
    """

    def __init__(self, context: Context, job: PlanningJob, display: DisplayPlannedPath) -> None:
        self._context = context
        self._job = job
        self._display = display
        context.serve(Service, 'compute_cartesian_path', self._answer)

    async def _answer(
        self, request: Service.Request, response: Service.Response
    ) -> Service.Response:
        with reported(self._context.logger, 'compute_cartesian_path', response.error_code):
            await self._fill(request, response)
        return response

    async def _fill(self, request: Service.Request, response: Service.Response) -> None:
        context = self._context
        scene = await self._job.scene(request.start_state)
        wanted = CartesianRequest(
            group_name=request.group_name,
            waypoints=tuple(pose_from_message(pose) for pose in request.waypoints),
            link_name=request.link_name,
            start_state=start_state_from_message(request.start_state),
            max_step=float(request.max_step),
            avoid_collisions=bool(request.avoid_collisions),
            path_constraints=constraints_from_message(request.path_constraints),
            max_velocity_scaling_factor=float(request.max_velocity_scaling_factor),
            max_acceleration_scaling_factor=float(request.max_acceleration_scaling_factor),
            cartesian_speed_limited_link=request.cartesian_speed_limited_link,
            max_cartesian_speed=float(request.max_cartesian_speed),
            frame_id=request.header.frame_id,
        )
        answer = await context.planning.submit(
            lambda: context.planner.cartesian_path(wanted, scene)
        )
        fill_error(response.error_code, answer.error_code, answer.message, answer.source)
        if answer.error_code != MoveItErrorCode.SUCCESS:
            return
        response.fraction = float(answer.fraction)
        if not len(answer.trajectory):
            return
        carried = context.started(scene, wanted.start_state).attached.values()
        response.start_state = robot_state_to_message(
            answer.start, context.frame, attached=carried
        )
        response.solution = robot_trajectory_message(answer.trajectory, context.frame)
        self._display.publish(response.start_state, response.solution)
