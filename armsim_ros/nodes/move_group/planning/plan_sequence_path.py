# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The service ``plan_sequence_path``."""

from __future__ import annotations

from moveit_msgs.msg import MotionSequenceRequest
from moveit_msgs.srv import GetMotionSequence as Service

from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.failures import reported
from armsim_ros.nodes.move_group.planning.sequence_job import SequenceJob


class PlanSequencePath:
    """
    Plans sequences of motions in the default pipeline and never moves.

    :param context: the parts of move_group.
    :param job: runs the planner.
    """

    def __init__(self, context: Context, job: SequenceJob) -> None:
        self._context = context
        self._job = job
        context.serve(Service, 'plan_sequence_path', self._answer)

    async def _answer(
        self, request: Service.Request, response: Service.Response
    ) -> Service.Response:
        answer = response.response
        with reported(self._context.logger, 'plan_sequence_path', answer.error_code):
            await self._job.run(request.request, answer, pipeline=self._pipeline(request.request))
        return response

    def _pipeline(self, request: MotionSequenceRequest) -> str:
        """Return the default pipeline; an unknown pipeline of the first motion stays."""
        default: str = self._context.planning_parameters.default_planning_pipeline
        wanted = request.items[0].req.pipeline_id if request.items else ''
        if not wanted or wanted == default:
            return default
        if wanted not in self._context.planning_parameters.planning_pipelines:
            return wanted
        self._context.logger.warning(
            f"plan_sequence_path plans in the default pipeline '{default}' and not in '{wanted}', "
            'which the first motion names; use the action sequence_move_group with plan_only, or '
            'set default_planning_pipeline')
        return default
