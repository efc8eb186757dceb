# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The actions ``follow_joint_trajectory`` and ``gripper_cmd``, and ``query_state``."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import partial
from typing import Any

from control_msgs.action import FollowJointTrajectory, GripperCommand, ParallelGripperCommand
from control_msgs.srv import QueryTrajectoryState
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import GoalEvent, ServerGoalHandle
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.task import Future
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from armsim_ros.control.command_controllers.gripper_controller import (
    GripperController,
    ParallelGripperController,
)
from armsim_ros.control.mailbox import GoalStatus
from armsim_ros.control.trajectory.goal import TrajectoryGoal
from armsim_ros.control.trajectory.joint_trajectory_controller import JointTrajectoryController
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import ns_from_time, seconds_from_duration
from armsim_ros.nodes.conversions.trajectory import (
    fill_feedback,
    tolerances_from_messages,
    trajectory_from_message,
)
from armsim_ros.nodes.polling_node import KeptResults
from armsim_ros.nodes.simulation.dispatcher import Dispatcher, wake

#: How often discovery is checked [s], and how many times at most.
_PERIOD, _TRIES = 0.005, 100


class ClientDiscovery:
    """Compares a service's discovered request writers and reply readers."""

    def __init__(self, node: Node, dispatcher: Dispatcher, service: str) -> None:
        self._node, self._dispatcher = node, dispatcher
        self._service = node.resolve_service_name(service)
        self._request_topic = f'rq{self._service}Request'
        self._tolerated = 0

    async def completed(self) -> None:
        """Return when every client that can ask can be answered too, or after half a second."""
        for _ in range(_TRIES):
            if self._unanswerable() <= self._tolerated:
                return
            later = Future()
            self._dispatcher.post_later(_PERIOD, partial(self._resume, later))
            await later
        # Something that only writes requests, such as a recorder's player: not to be waited for.
        self._tolerated = self._unanswerable()

    def _unanswerable(self) -> int:
        asking = self._node.get_publishers_info_by_topic(self._request_topic, no_mangle=True)
        missing = len(asking) - self._node.count_clients(self._service)
        self._tolerated = min(self._tolerated, max(missing, 0))
        return missing

    def _resume(self, later: Future) -> None:
        later.set_result(None)
        wake(self._node)


#: How long a result waits for a client that asks late, in a time that may run a hundred times
#: faster than the client's [s], and how many: a burst of goals ends all but the last.
RESULT_TIMEOUT, MOST_RESULTS = 600, 1000


@dataclass(eq=False)
class RunningGoal:
    """
    An accepted goal without a result.

    :param goal: the controller's goal.
    :param handle: its handle in the action server.
    :param done: resumes the coroutine that waits in the executor for the goal's end.
    """

    goal: Any
    handle: ServerGoalHandle
    done: Future
    next_feedback_ns: int = 0


class GoalServer(ABC):
    """
    An action server whose goals a controller decides and the control loop executes.

    It only carries messages. The end of a goal comes from the loop's thread through the
    dispatcher and resumes a coroutine that waits in the executor.

    :param kind: the action type.
    :param name: the action's name.
    """

    def __init__(self, node: Node, dispatcher: Dispatcher, kind: type[Any], name: str) -> None:
        self._node, self._dispatcher = node, dispatcher
        self._taken: tuple[Any, Any] | None = None
        self._discoveries = [
            ClientDiscovery(node, dispatcher, f'{name}/_action/{service}')
            for service in ('send_goal', 'cancel_goal', 'get_result')]
        self._running: dict[bytes, RunningGoal] = {}
        self._ending = ''
        self._server = ActionServer(
            node, kind, name, execute_callback=self._execute, goal_callback=self._decide,
            handle_accepted_callback=self._accept, cancel_callback=self._cancel,
            **qos.ACTION_SERVICES, result_timeout=RESULT_TIMEOUT)
        self._results = KeptResults(self._server, MOST_RESULTS)

    @property
    def running(self) -> tuple[RunningGoal, ...]:
        """The goals without a result; a preempted goal stays until its result is out."""
        return tuple(self._running.values())

    def end(self, sentence: str) -> None:
        """
        Abort running goals and refuse new ones; only from the executor's thread.

        :param sentence: why, for the clients.
        """
        self._ending = sentence
        for running in self.running:
            if not running.done.done():
                running.done.set_result(None)

    def destroy(self) -> None:
        """Destroy the action server."""
        self._server.destroy()

    @abstractmethod
    def _send(self, request: Any) -> Any:
        """Pass a goal message to the controller; return the goal, None if it is rejected."""

    @abstractmethod
    def _cancel_goal(self, goal: Any) -> bool:
        """Ask the controller to cancel; False if the goal has ended already."""

    @abstractmethod
    def _result(self, goal: Any) -> Any:
        """Return the result message of a goal that has ended."""

    @abstractmethod
    def _aborted(self, sentence: str) -> Any:
        """Return the result message of a goal that the program aborts."""

    async def _decide(self, request: Any) -> GoalResponse:
        for discovery in self._discoveries:
            await discovery.completed()
        goal = None if self._ending else self._send(request)
        if goal is None:
            return GoalResponse.REJECT
        self._taken = (request, goal)
        return GoalResponse.ACCEPT

    def _accept(self, handle: ServerGoalHandle) -> None:
        if self._taken is None or self._taken[0] is not handle.request:
            raise RuntimeError('a goal was accepted that the controller does not know')
        running = RunningGoal(self._taken[1], handle, Future())
        self._taken = None
        self._running[bytes(handle.goal_id.uuid)] = running
        handle.execute()
        # Called in the loop's thread, or here and now where the goal has ended already.
        running.goal.add_done_callback(lambda _: self._dispatcher.post(lambda: self._end(running)))

    def _end(self, running: RunningGoal) -> None:
        if not running.done.done():
            running.done.set_result(None)
        wake(self._node)

    def _cancel(self, handle: ServerGoalHandle) -> CancelResponse:
        running = self._running.get(bytes(handle.goal_id.uuid))
        if running is None or not self._cancel_goal(running.goal):
            return CancelResponse.REJECT
        return CancelResponse.ACCEPT

    async def _execute(self, handle: ServerGoalHandle) -> Any:
        key = bytes(handle.goal_id.uuid)
        running = self._running[key]
        await running.done
        del self._running[key]
        self._results.add(handle)
        status = running.goal.status
        if self._ending and not running.goal.done:
            handle.abort()
            return self._aborted(self._ending)
        if status == GoalStatus.SUCCEEDED:
            handle.succeed()
        elif status == GoalStatus.CANCELED:
            if not handle.is_cancel_requested:
                # Canceled by the controller itself; no public call of rclpy leads there.
                handle._update_state(GoalEvent.CANCEL_GOAL)
            handle.canceled()
        else:
            handle.abort()
        return self._result(running.goal)


class RejectedGoals:
    """
    Publishes why a goal or trajectory was refused; an action's rejection has no room for it.

    :param profile: how long a reason is there for late subscribers, among others.
    """

    def __init__(self, node: Node, profile: QoSProfile = qos.EVENTS) -> None:
        self._publisher = node.create_publisher(String, '~/rejected_goals', profile)

    def publish(self, reason: str) -> None:
        """Publish a reason."""
        self._publisher.publish(String(data=reason))


_MOVING = (GoalStatus.EXECUTING, GoalStatus.CANCELING)


class FollowJointTrajectoryServer(GoalServer):
    """The action server of a trajectory controller."""

    def __init__(
        self, node: Node, controller: JointTrajectoryController, dispatcher: Dispatcher
    ) -> None:
        self._controller = controller
        self._feedback = FollowJointTrajectory.Feedback()
        self._feedback_period_ns = round(1e9 / controller.parameters.action_monitor_rate)
        super().__init__(node, dispatcher, FollowJointTrajectory, '~/follow_joint_trajectory')

    def publish_feedback(self, time_ns: int) -> None:
        """Publish feedback of the active goal, if it is due."""
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
            seconds_from_duration(request.goal_time_tolerance))
        return response.goal

    def _cancel_goal(self, goal: TrajectoryGoal) -> bool:
        return self._controller.cancel(goal)

    def _result(self, goal: TrajectoryGoal) -> FollowJointTrajectory.Result:
        assert goal.result is not None
        return FollowJointTrajectory.Result(
            error_code=int(goal.result.code), error_string=goal.result.message)

    def _aborted(self, sentence: str) -> FollowJointTrajectory.Result:
        return FollowJointTrajectory.Result(
            error_code=FollowJointTrajectory.Result.INVALID_GOAL, error_string=sentence)


def answer_query(
    controller: JointTrajectoryController,
    request: QueryTrajectoryState.Request, response: QueryTrajectoryState.Response,
) -> QueryTrajectoryState.Response:
    """Answer with the reference at a given time."""
    result = controller.query_state(ns_from_time(request.time))
    response.success = result.success
    response.message = result.message
    response.name = list(result.names)
    response.position = result.positions.tolist()
    response.velocity = result.velocities.tolist()
    response.acceleration = result.accelerations.tolist()
    return response


class GripperCommandServer(GoalServer):
    """The action server of a position or effort gripper; no feedback, as in the reference."""

    def __init__(self, node: Node, controller: GripperController, dispatcher: Dispatcher) -> None:
        self._controller = controller
        super().__init__(node, dispatcher, GripperCommand, '~/gripper_cmd')

    def _send(self, request: GripperCommand.Goal) -> Any:
        command = request.command
        return self._controller.send_goal(command.position, command.max_effort).goal

    def _cancel_goal(self, goal: Any) -> bool:
        return self._controller.cancel(goal)

    def _result(self, goal: Any) -> GripperCommand.Result:
        return GripperCommand.Result(
            position=goal.result.position, effort=goal.result.effort, stalled=goal.result.stalled,
            reached_goal=goal.result.reached_goal)

    def _aborted(self, sentence: str) -> GripperCommand.Result:
        return GripperCommand.Result()  # it has no room for a sentence


class ParallelGripperCommandServer(GoalServer):
    """The action server of a parallel gripper; no feedback, as in the reference."""

    def __init__(
        self, node: Node, controller: ParallelGripperController, dispatcher: Dispatcher
    ) -> None:
        self._controller = controller
        super().__init__(node, dispatcher, ParallelGripperCommand, '~/gripper_cmd')

    def _send(self, request: ParallelGripperCommand.Goal) -> Any:
        command = request.command
        return self._controller.send_goal(
            list(command.position), list(command.velocity), list(command.effort)).goal

    def _cancel_goal(self, goal: Any) -> bool:
        return self._controller.cancel(goal)

    def _result(self, goal: Any) -> ParallelGripperCommand.Result:
        state = JointState(
            name=list(self._controller.joints), position=[goal.result.position],
            velocity=[goal.result.velocity], effort=[goal.result.effort])
        return ParallelGripperCommand.Result(
            state=state, stalled=goal.result.stalled, reached_goal=goal.result.reached_goal)

    def _aborted(self, sentence: str) -> ParallelGripperCommand.Result:
        return ParallelGripperCommand.Result()  # it has no room for a sentence
