# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The service ``apply_planning_scene``."""

from __future__ import annotations

from moveit_msgs.srv import ApplyPlanningScene as Service

from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.scene.planning_scene import apply_scene_message


class ApplyPlanningScene:
    """
    Changes the scene; when the answer comes, every later request sees the change.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        context.serve(Service, 'apply_planning_scene', self._answer)

    async def _answer(
        self, request: Service.Request, response: Service.Response
    ) -> Service.Response:
        response.success = await apply_scene_message(
            self._context, request.scene, 'apply_planning_scene'
        )
        return response
