# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The service ``query_planner_interface``."""

from __future__ import annotations

from moveit_msgs.msg import PlannerInterfaceDescription
from moveit_msgs.srv import QueryPlannerInterfaces as Service

from armsim_ros.nodes.move_group.context import Context
from armsim_ros.planning.pilz.commands import COMMANDS
from armsim_ros.planning.pilz.commands import PIPELINE as PILZ

NAMES = {'ompl': 'OMPL', PILZ: 'Pilz Industrial Motion Planner'}


class QueryPlannerInterface:
    """
    Lists the pipelines and their planners.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        context.serve(Service, 'query_planner_interface', self._answer)

    async def _answer(
        self, request: Service.Request, response: Service.Response
    ) -> Service.Response:
        settings = self._context.planner.settings
        groups = tuple(self._context.robot.semantic.groups)
        response.planner_interfaces = [
            PlannerInterfaceDescription(
                name=NAMES.get(pipeline, pipeline),
                pipeline_id=pipeline,
                planner_ids=list(
                    COMMANDS if pipeline == PILZ else settings.planners.planner_ids(groups)
                ),
            )
            for pipeline in settings.pipelines
        ]
        return response
