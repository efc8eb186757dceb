# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The service ``compute_fk``."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import PoseStamped
from moveit_msgs.srv import GetPositionFK as Service

from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.model.transforms import inverse_pose
from armsim_ros.nodes.conversions.geometry import pose_to_message
from armsim_ros.nodes.conversions.robot_state import start_state_from_message
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.failures import fill_error, reported
from armsim_ros.nodes.move_group.planning.planning_job import log_refused


class ComputeFk:
    """
    Returns the poses of links, attached objects and subframes.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        context.serve(Service, 'compute_fk', self._answer)

    async def _answer(
        self, request: Service.Request, response: Service.Response
    ) -> Service.Response:
        with reported(self._context.logger, 'compute_fk', response.error_code):
            await self._fill(request, response)
        return response

    async def _fill(self, request: Service.Request, response: Service.Response) -> None:
        if not request.fk_link_names:
            raise PlanningError(
                MoveItErrorCode.INVALID_LINK_NAME, 'no link names were given', 'compute_fk'
            )
        context = self._context
        present = await context.present_scene()
        scene = context.started(present, start_state_from_message(request.robot_state))
        frame = request.header.frame_id or context.frame
        to_frame = inverse_pose(present.transform(frame))
        unknown = []
        for name in request.fk_link_names:
            if scene.robot_frame(name) is None:
                unknown.append(name)
                continue
            message: Any = PoseStamped()
            message.header.frame_id = frame
            message.header.stamp = context.node.get_clock().now().to_msg()
            message.pose = pose_to_message(to_frame @ scene.frame_pose(name))
            response.pose_stamped.append(message)
            response.fk_link_names.append(name)
        if unknown:
            raise PlanningError(
                MoveItErrorCode.INVALID_LINK_NAME,
                f"no link, attached object or subframe is called {', '.join(map(repr, unknown))}",
                'compute_fk',
            )
        log_refused(scene, context.logger)
        fill_error(response.error_code, MoveItErrorCode.SUCCESS, scene.refused)
