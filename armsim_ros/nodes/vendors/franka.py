# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Arms of Franka, as ``franka_hardware`` presents them: what clears a reflex."""

from __future__ import annotations

from typing import Any

from franka_msgs.action import ErrorRecovery
from rclpy.action import ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup

from armsim_ros.errors import SimulationError
from armsim_ros.nodes import qos
from armsim_ros.nodes.vendors.endpoints import Endpoints


class FrankaEndpoints(Endpoints):
    """The action ``action_server/error_recovery``."""

    def create(self) -> None:
        """Create the node of the action."""
        node = self.nodes.new_node('action_server')
        self._logger = node.get_logger()
        self._server = ActionServer(
            node, ErrorRecovery, '~/error_recovery', self._recover,
            callback_group=ReentrantCallbackGroup(), **qos.ACTION_SERVICES)

    async def _recover(self, handle: ServerGoalHandle) -> Any:
        try:
            refusal = await self.nodes.change(self.nodes.arm.clear_stop)
        except SimulationError as error:
            refusal = str(error)
        if refusal:
            self._logger.error(f'no recovery: {refusal}')
            handle.abort()
        else:
            handle.succeed()
        return ErrorRecovery.Result()
