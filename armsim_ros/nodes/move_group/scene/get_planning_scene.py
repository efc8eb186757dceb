# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The service ``get_planning_scene``."""

from __future__ import annotations

from moveit_msgs.srv import GetPlanningScene as Service
from sensor_msgs.msg import JointState

from armsim_ros.nodes.conversions.planning_scene import Component, scene_to_message
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.failures import reported


class GetPlanningScene:
    """
    Answers with the requested parts of the scene, all of them for 0.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        context.serve(Service, 'get_planning_scene', self._answer)

    async def _answer(
        self, request: Service.Request, response: Service.Response
    ) -> Service.Response:
        wanted = Component(request.components.components) or Component.ALL
        with reported(self._context.logger, 'get_planning_scene', None):
            scene = await self._context.present_scene()
            response.scene = await self._context.edits.submit(
                lambda: scene_to_message(scene, wanted)
            )
            self._add_velocities(response.scene.robot_state.joint_state)
        return response

    def _add_velocities(self, state: JointState) -> None:
        """Add measured velocities to the positions if ``monitor_dynamics`` is set."""
        states = self._context.states
        if states.monitor_dynamics:
            state.velocity = [states.velocities.get(name, 0.0) for name in state.name]
