# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The service ``~/query_state``."""

from __future__ import annotations

from control_msgs.srv import QueryTrajectoryState
from rclpy.node import Node

from armsim_ros.control.trajectory.joint_trajectory_controller import JointTrajectoryController
from armsim_ros.nodes.conversions.time import ns_from_time


class QueryStateService:
    """
    Answers with the reference at a given time.

    :param node: the controller's node.
    """

    def __init__(self, node: Node, controller: JointTrajectoryController) -> None:
        self._controller = controller
        self._service = node.create_service(
            QueryTrajectoryState, '~/query_state', self._answer
        )

    def _answer(
        self, request: QueryTrajectoryState.Request, response: QueryTrajectoryState.Response
    ) -> QueryTrajectoryState.Response:
        result = self._controller.query_state(ns_from_time(request.time))
        response.success = result.success
        response.message = result.message
        response.name = list(result.names)
        response.position = result.positions.tolist()
        response.velocity = result.velocities.tolist()
        response.acceleration = result.accelerations.tolist()
        return response
