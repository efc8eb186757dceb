# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The actions ``follow_joint_trajectory`` and ``gripper_cmd``, and ``query_state``."""

from __future__ import annotations

from typing import Any

from control_msgs.action import FollowJointTrajectory, GripperCommand, ParallelGripperCommand
from control_msgs.srv import QueryTrajectoryState
from rclpy.node import Node
from sensor_msgs.msg import JointState

from armsim_ros.control.gripper.gripper_controller import (
    GripperController,
    ParallelGripperController,
)
from armsim_ros.control.mailbox import GoalStatus
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


class GripperCommandServer(GoalServer):
    """
    The action server of a position or effort gripper; no feedback, as in the reference.

    :param node: the controller's node.
    """

    def __init__(
        self, node: Node, controller: GripperController, dispatcher: Dispatcher
    ) -> None:
        self._controller = controller
        super().__init__(node, dispatcher, GripperCommand, '~/gripper_cmd')

    def _send(self, request: GripperCommand.Goal) -> Any:
        command = request.command
        return self._controller.send_goal(command.position, command.max_effort).goal

    def _cancel_goal(self, goal: Any) -> bool:
        return self._controller.cancel(goal)

    def _result(self, goal: Any) -> GripperCommand.Result:
        return GripperCommand.Result(
            position=goal.result.position,
            effort=goal.result.effort,
            stalled=goal.result.stalled,
            reached_goal=goal.result.reached_goal,
        )

    def _aborted(self, sentence: str) -> GripperCommand.Result:
        return GripperCommand.Result()  # it has no room for a sentence


class ParallelGripperCommandServer(GoalServer):
    """
    The action server of a parallel gripper; no feedback, as in the reference.

    :param node: the controller's node.
    """

    def __init__(
        self, node: Node, controller: ParallelGripperController, dispatcher: Dispatcher
    ) -> None:
        self._controller = controller
        super().__init__(node, dispatcher, ParallelGripperCommand, '~/gripper_cmd')

    def _send(self, request: ParallelGripperCommand.Goal) -> Any:
        command = request.command
        return self._controller.send_goal(
            list(command.position), list(command.velocity), list(command.effort)
        ).goal

    def _cancel_goal(self, goal: Any) -> bool:
        return self._controller.cancel(goal)

    def _result(self, goal: Any) -> ParallelGripperCommand.Result:
        state = JointState(
            name=list(self._controller.joints),
            position=[goal.result.position],
            velocity=[goal.result.velocity],
            effort=[goal.result.effort],
        )
        return ParallelGripperCommand.Result(
            state=state, stalled=goal.result.stalled, reached_goal=goal.result.reached_goal
        )

    def _aborted(self, sentence: str) -> ParallelGripperCommand.Result:
        return ParallelGripperCommand.Result()  # it has no room for a sentence
