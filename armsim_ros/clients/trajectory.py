# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A typed client of the action ``follow_joint_trajectory``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import threading
from typing import Any

from action_msgs.msg import GoalStatus
from control_msgs.action import FollowJointTrajectory
from control_msgs.msg import JointTolerance
from rclpy.qos import QoSHistoryPolicy, QoSProfile
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from armsim_ros.clients.client_node import ClientNode, PATIENCE
from armsim_ros.clients.node import GoalRun
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import duration_from_seconds

ALL = QoSProfile(history=QoSHistoryPolicy.KEEP_ALL)

SUCCEEDED = GoalStatus.STATUS_SUCCEEDED
CANCELED = GoalStatus.STATUS_CANCELED
ABORTED = GoalStatus.STATUS_ABORTED


@dataclass(frozen=True)
class Outcome:
    """How a goal ended; ``status`` is a constant of ``action_msgs/msg/GoalStatus``."""

    status: int
    error_code: int
    error_string: str


def trajectory_message(
    joint_names: Sequence[str], points: Sequence[tuple[float, Sequence[float]]],
    velocities: Sequence[Sequence[float]] | None = None
) -> JointTrajectory:
    """
    Return a trajectory.

    :param joint_names: (n,).
    :param points: (time from start [s], (n,) positions [rad or m]) of each waypoint.
    :param velocities: (points, n) [rad/s or m/s], or None for positions only.
    """
    message = JointTrajectory(joint_names=list(joint_names))
    for i, (time_from_start, positions) in enumerate(points):
        point = JointTrajectoryPoint(
            positions=[float(value) for value in positions],
            time_from_start=duration_from_seconds(time_from_start))
        if velocities is not None:
            point.velocities = [float(value) for value in velocities[i]]
        message.points.append(point)
    return message


class Goal:
    """
    A goal on its way.

    :param client: the client that sends it.
    """

    def __init__(self, client: TrajectoryClient) -> None:
        self.feedback: list[Any] = []
        self._node = client.client
        self._condition = threading.Condition()
        self._run: GoalRun | None = None

    def accepted(self, timeout: float = PATIENCE) -> bool:
        """Wait for the server's answer and return whether it took the goal."""
        assert self._run is not None
        return bool(self._node.result(self._run.accepted, timeout, 'answer to the goal'))

    def result(self, timeout: float = 60.0) -> Outcome:
        """Wait for the end of an accepted goal."""
        assert self._run is not None
        assert self.accepted(timeout), 'the goal was rejected'
        response = self._node.result(self._run.result, timeout, 'result')
        return Outcome(response.status, response.result.error_code, response.result.error_string)

    def cancel(self, timeout: float = PATIENCE) -> bool:
        """Ask for cancellation; return whether the server agreed."""
        assert self._run is not None
        assert self.accepted(timeout), 'the goal was rejected'
        response = self._node.result(self._run.cancel(), timeout, 'answer to the cancellation')
        return bool(response.goals_canceling)

    def wait_for_feedback(self, count: int = 1, timeout: float = PATIENCE) -> list[Any]:
        """Return all feedback as soon as there are ``count`` messages."""
        with self._condition:
            enough = self._condition.wait_for(lambda: len(self.feedback) >= count, timeout)
            assert enough, f'{len(self.feedback)} of {count} feedback messages in {timeout} s'
            return list(self.feedback)

    def _receive(self, feedback: Any) -> None:
        with self._condition:
            self.feedback.append(feedback)
            self._condition.notify_all()


class TrajectoryClient:
    """
    Sends trajectories to a controller.

    :param client: the node to use.
    :param controller: the controller's full name, such as ``/sunday/arm_joint_controller``.
    """

    def __init__(self, client: ClientNode, controller: str) -> None:
        self.client, self.controller = client, controller
        self._name = f'{controller}/follow_joint_trajectory'
        self._action = client.action(
            FollowJointTrajectory,
            self._name,
            # The usual depth of 10 loses answers when many goals are sent at once.
            goal_service_qos_profile=ALL,
            result_service_qos_profile=ALL,
            feedback_sub_qos_profile=QoSProfile(depth=100))
        # Transient-local, so that a message published before the two have met is not lost.
        self._publisher = client.node.create_publisher(
            JointTrajectory, f'{controller}/joint_trajectory', qos.LATCHED)

    def wait_for_server(self, timeout: float = PATIENCE) -> None:
        """Wait until the action server answers to discovery."""
        assert self._action.wait_for_server(timeout), (
            f'no action server {self._name} in {timeout} s')

    def send(
        self, trajectory: JointTrajectory, *, path_tolerance: Mapping[str, float] | None = None,
        goal_tolerance: Mapping[str, float] | None = None, goal_time_tolerance: float = 0.0,
    ) -> Goal:
        """
        Send a goal and return at once.

        :param path_tolerance: joint -> position [rad or m].
        :param goal_tolerance: joint -> position [rad or m].
        :param goal_time_tolerance: [s].
        """
        return self.send_goal(
            FollowJointTrajectory.Goal(
                trajectory=trajectory, path_tolerance=_tolerances(path_tolerance or {}),
                goal_tolerance=_tolerances(goal_tolerance or {}),
                goal_time_tolerance=duration_from_seconds(goal_time_tolerance)))

    def send_goal(self, message: FollowJointTrajectory.Goal) -> Goal:
        """Send a goal message as it is and return at once."""
        goal = Goal(self)
        goal._run = self.client.goal(FollowJointTrajectory, self._name, message, goal._receive)
        return goal

    def close(self) -> None:
        """Take action client and publisher away."""
        def drop() -> None:
            self.client.drop_action(FollowJointTrajectory, self._name)
            self.client.node.destroy_publisher(self._publisher)

        self.client.in_executor(drop)

    def publish(self, trajectory: JointTrajectory) -> None:
        """Publish a trajectory on the controller's topic."""
        self._publisher.publish(trajectory)


def _tolerances(positions: Mapping[str, float]) -> list[JointTolerance]:
    return [JointTolerance(name=name, position=value) for name, value in positions.items()]
