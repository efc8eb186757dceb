# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The service ``compute_ik``."""

from __future__ import annotations

from typing import Any

from moveit_msgs.srv import GetPositionIK as Service

from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.nodes.conversions.constraints import constraints_from_message
from armsim_ros.nodes.conversions.geometry import pose_from_message
from armsim_ros.nodes.conversions.robot_state import (
    robot_state_to_message,
    start_state_from_message,
)
from armsim_ros.nodes.conversions.time import seconds_from_duration
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.failures import fill_error, reported
from armsim_ros.planning.queries import IKRequest, LinkPose


class ComputeIk:
    """
    Finds joint positions that put links at poses.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        context.serve(Service, 'compute_ik', self._answer)

    async def _answer(
        self, request: Service.Request, response: Service.Response
    ) -> Service.Response:
        with reported(self._context.logger, 'compute_ik', response.error_code):
            await self._fill(request.ik_request, response)
        return response

    async def _fill(self, message: Any, response: Service.Response) -> None:
        context = self._context
        scene = await context.present_scene()
        request = IKRequest(
            group_name=message.group_name,
            targets=self._targets(message),
            start_state=start_state_from_message(message.robot_state),
            constraints=constraints_from_message(message.constraints),
            avoid_collisions=bool(message.avoid_collisions),
            timeout=seconds_from_duration(message.timeout),
        )
        clock = context.planning_clock()
        answer = await context.queries.submit(
            lambda: context.query_planner.ik_in_turns(request, scene, clock=clock)
        )
        fill_error(response.error_code, answer.error_code, answer.message, 'compute_ik')
        if answer.error_code == MoveItErrorCode.SUCCESS:
            response.solution = robot_state_to_message(answer.positions, context.frame)

    def _targets(self, message: Any) -> tuple[LinkPose, ...]:
        """Return the targets; a vector of a single pose needs no link."""
        if not message.pose_stamped_vector:
            return (self._target(message.ik_link_name, message.pose_stamped),)
        names = message.ik_link_names
        if len(message.pose_stamped_vector) == 1:
            names = [*names, ''][:1]
        if len(names) != len(message.pose_stamped_vector):
            raise PlanningError(
                MoveItErrorCode.INVALID_LINK_NAME,
                f'{len(names)} ik_link_names and {len(message.pose_stamped_vector)} poses; '
                'each pose needs its link',
                'compute_ik',
            )
        return tuple(
            self._target(name, pose)
            for name, pose in zip(names, message.pose_stamped_vector, strict=True)
        )

    @staticmethod
    def _target(link_name: str, message: Any) -> LinkPose:
        return LinkPose(
            link_name, pose_from_message(message.pose), message.header.frame_id
        )
