# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``pipeline_state``: the progress of a request."""

from __future__ import annotations

from collections.abc import Iterator

from moveit_msgs.msg import MotionPlanRequest, MotionPlanResponse, MoveItErrorCodes, PipelineState
from rclpy.node import Node

from armsim_ros.config.move_group.ompl_planning import OmplSettings
from armsim_ros.nodes.move_group.planning.planner_services import (
    request_adapters,
    response_adapters,
)

#: What planners call themselves, by the first part of their pipeline's name.
PLANNERS = {'pilz': 'Pilz Industrial Motion Planner'}
DEPTH = 20


class PipelineStates:
    """
    Publishes the stages of a plan: an empty stage when it begins, all others when it is complete.

    The planner answers once, with the stage that refused the request, so all that it passed are
    published together. Nothing is composed without subscribers.

    :param settings: the pipeline's adapters and the topic's name; '' publishes nothing.
    """

    def __init__(self, node: Node, settings: OmplSettings) -> None:
        self._settings = settings
        self._publisher = None
        if settings.progress_topic:
            self._publisher = node.create_publisher(PipelineState, settings.progress_topic, DEPTH)

    def begin(self, request: MotionPlanRequest) -> None:
        """Publish that work on a request has begun."""
        self._publish(request, MotionPlanResponse(), '')

    def end(
        self, request: MotionPlanRequest, response: MotionPlanResponse, pipeline: str
    ) -> None:
        """
        Publish each stage that a request has passed, and the stage that refused it.

        :param response: its error code names the stage.
        :param pipeline: that planned.
        """
        if not self._heard:
            return
        success = response.error_code.val == MoveItErrorCodes.SUCCESS
        passed = MotionPlanResponse()
        passed.error_code.val = MoveItErrorCodes.SUCCESS
        stages = list(self._stages(pipeline))
        planned = stages.index(self._planner(pipeline))
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

    def _publish(
        self, request: MotionPlanRequest, response: MotionPlanResponse, stage: str
    ) -> None:
        if self._publisher is not None and self._heard:
            self._publisher.publish(
                PipelineState(request=request, response=response, pipeline_stage=stage)
            )

    def _stages(self, pipeline: str) -> Iterator[str]:
        yield from request_adapters(self._settings, pipeline)
        yield self._planner(pipeline)
        yield from response_adapters(self._settings, pipeline)

    @staticmethod
    def _planner(pipeline: str) -> str:
        return PLANNERS.get(pipeline.partition('_')[0], pipeline.upper())
