# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The action ``~/follow_joint_trajectory`` and the service ``~/query_state``."""

from __future__ import annotations

from control_msgs.action import FollowJointTrajectory
from control_msgs.srv import QueryTrajectoryState
from rclpy.node import Node

from armsim_ros.control.action_goal import GoalStatus
from armsim_ros.control.trajectory.goal import TrajectoryGoal
from armsim_ros.control.trajectory.joint_trajectory_controller import JointTrajectoryController
from armsim_ros.nodes.conversions.joint_state import fill_feedback
from armsim_ros.nodes.conversions.time import ns_from_time, seconds_from_duration
from armsim_ros.nodes.conversions.trajectory import (
    tolerances_from_messages,
    trajectory_from_message,
)
from armsim_ros.nodes.simulation.controllers.goal_server import GoalServer
from armsim_ros.nodes.simulation.dispatcher import Dispatcher

_MOVING = (GoalStatus.EXECUTING, GoalStatus.CANCELING)


class FollowJointTrajectoryServer(GoalServer):
    """
    The action server of a trajectory controller.

    :param node: the controller's node.
    """

    def __init__(
        self, node: Node, controller: JointTrajectoryController, dispatcher: Dispatcher
    ) -> None:
        self._controller = controller
        self._feedback = FollowJointTrajectory.Feedback()
        self._feedback_period_ns = round(1e9 / controller.parameters.action_monitor_rate)
        super().__init__(node, dispatcher, FollowJointTrajectory, '~/follow_joint_trajectory')

    def publish_feedback(self, time_ns: int) -> None:
        """
        Publish feedback of the active goal, if it is due.

        :param time_ns: [ns] of the simulation.
        """
        for running in self.running:
            if running.goal.status not in _MOVING or time_ns < running.next_feedback_ns:
                continue
            snapshot = self._controller.snapshot()
            # Executing already, the goal may still wait for the end of its first update.
            if snapshot is not None and snapshot.goal is running.goal:
                running.next_feedback_ns = time_ns + self._feedback_period_ns
                fill_feedback(self._feedback, snapshot)
                running.handle.publish_feedback(self._feedback)

    def _send(self, request: FollowJointTrajectory.Goal) -> TrajectoryGoal | None:
        response = self._controller.send_goal(
            trajectory_from_message(request.trajectory),
            tolerances_from_messages(request.path_tolerance),
            tolerances_from_messages(request.goal_tolerance),
            seconds_from_duration(request.goal_time_tolerance),
        )
        return response.goal

    def _cancel_goal(self, goal: TrajectoryGoal) -> bool:
        return self._controller.cancel(goal)

    def _result(self, goal: TrajectoryGoal) -> FollowJointTrajectory.Result:
        assert goal.result is not None
        return FollowJointTrajectory.Result(
            error_code=int(goal.result.code), error_string=goal.result.message
        )

    def _aborted(self, sentence: str) -> FollowJointTrajectory.Result:
        return FollowJointTrajectory.Result(
            error_code=FollowJointTrajectory.Result.INVALID_GOAL, error_string=sentence
        )


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
