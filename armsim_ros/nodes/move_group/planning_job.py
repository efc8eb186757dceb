# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""One planning request from its message to an answer in messages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from moveit_msgs.msg import MotionPlanRequest as RequestMessage
from moveit_msgs.msg import MoveItErrorCodes, RobotState, RobotTrajectory
from moveit_msgs.msg import PlanningScene as SceneMessage

from armsim_ros.errors import PlanningError
from armsim_ros.nodes.conversions.motion_plan_request import (
    error_code_message,
    request_from_message,
    robot_trajectory_message,
)
from armsim_ros.nodes.conversions.planning_scene import update_from_message
from armsim_ros.nodes.conversions.robot_state import robot_state_to_message
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.display_planned_path import DisplayPlannedPath
from armsim_ros.planning.error_codes import MoveItErrorCode
from armsim_ros.planning.request import MotionPlanRequest, MotionPlanResponse
from armsim_ros.planning.scene import PlanningScene


def never() -> bool:
    """Return False: nobody cancels."""
    return False


@dataclass(frozen=True, eq=False)
class Plan:
    """A planner's answer with its messages; ``scene`` is the one that was planned in."""

    request: MotionPlanRequest
    response: MotionPlanResponse
    scene: PlanningScene
    start_message: RobotState
    trajectory_message: RobotTrajectory

    @property
    def error_code_message(self) -> MoveItErrorCodes:
        """The answer's code, sentence and source."""
        answer = self.response
        return error_code_message(answer.error_code, answer.message, answer.source)


class PlanningJob:
    """
    Runs the planner in its worker.

    :param context: the parts of move_group.
    :param display: gets every successful plan.
    """

    def __init__(self, context: Context, display: DisplayPlannedPath) -> None:
        """Keep the parts."""
        self._context = context
        self._display = display

    async def run(
        self,
        message: RequestMessage,
        *,
        scene_diff: SceneMessage | None = None,
        cancelled: Callable[[], bool] = never,
    ) -> Plan:
        """
        Plan and answer.

        :param scene_diff: laid over the monitored scene for this request alone.
        :param cancelled: asked now and then while the planner searches.
        :raises PlanningError: the message holds what cannot exist, or no state ever came.
        """
        context = self._context
        request = request_from_message(message)
        if message.start_state.is_diff or not message.start_state.joint_state.name:
            await self.current_state()
        scene = context.scene.snapshot()
        if scene_diff is not None:
            scene = overlay(scene, scene_diff)
        planner, clock = context.planner, context.clock
        response = await context.planning.submit(
            lambda: planner.plan(request, scene, clock=clock, cancelled=cancelled)
        )
        plan = self._in_messages(request, response, scene)
        if response.success:
            self._display.publish(plan.start_message, plan.trajectory_message)
        return plan

    async def current_state(self) -> None:
        """
        Bring the scene to the present.

        :raises PlanningError: no joint state ever came.
        """
        context = self._context
        if await context.states.current():
            return
        topics = ', '.join(context.states.topics)
        if context.states.count == 0:
            raise PlanningError(
                MoveItErrorCode.ROBOT_STATE_STALE,
                f'no joint state has arrived on {topics}; is the simulation running?',
                'joint_states',
            )
        context.logger.warning(
            f'no joint state newer than the request within 1 s on {topics}; using the last one'
        )

    def _in_messages(
        self, request: MotionPlanRequest, response: MotionPlanResponse, scene: PlanningScene
    ) -> Plan:
        frame = self._context.frame
        trajectory, start = RobotTrajectory(), RobotState()
        if response.success:
            carried: Any = scene.with_start_state(request.start_state).attached.values()
            trajectory = robot_trajectory_message(response.trajectory, frame)
            start = robot_state_to_message(response.trajectory_start, frame, attached=carried)
        return Plan(request, response, scene, start, trajectory)


def overlay(scene: PlanningScene, message: SceneMessage) -> PlanningScene:
    """
    Return a scene with a request's own changes.

    :raises PlanningError: a change is refused.
    """
    update = update_from_message(message)
    if update.is_diff and update.empty:
        return scene
    changed, refused = scene.with_update(update)
    if refused:
        raise PlanningError(
            MoveItErrorCode.INVALID_OBJECT_NAME, '; '.join(refused), 'planning_scene_diff'
        )
    return changed
