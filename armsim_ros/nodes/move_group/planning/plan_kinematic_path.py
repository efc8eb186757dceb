# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The service ``plan_kinematic_path``."""

from __future__ import annotations

from moveit_msgs.srv import GetMotionPlan as Service

from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.failures import reported
from armsim_ros.nodes.move_group.planning.planning_job import PlanningJob


class PlanKinematicPath:
    """
    Plans and never moves.

    :param context: the parts of move_group.
    :param job: runs the planner.
    """

    def __init__(self, context: Context, job: PlanningJob) -> None:
        self._context = context
        self._job = job
        context.serve(Service, 'plan_kinematic_path', self._answer)

    async def _answer(
        self, request: Service.Request, response: Service.Response
    ) -> Service.Response:
        answer = response.motion_plan_response
        with reported(self._context.logger, 'plan_kinematic_path', answer.error_code):
            plan = await self._job.run(request.motion_plan_request)
            answer.trajectory_start = plan.start_message
            answer.trajectory = plan.trajectory_message
            answer.group_name = request.motion_plan_request.group_name
            answer.planning_time = plan.response.planning_time
            answer.error_code = plan.error_code_message
        return response
