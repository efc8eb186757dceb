# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The base of the controllers' action servers, and the topic ``~/rejected_goals``."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import GoalEvent, ServerGoalHandle
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.task import Future
from std_msgs.msg import String

from armsim_ros.control.mailbox import GoalStatus
from armsim_ros.nodes import qos
from armsim_ros.nodes.kept_results import KeptResults
from armsim_ros.nodes.simulation.discovery import ClientDiscovery
from armsim_ros.nodes.simulation.dispatcher import Dispatcher, wake

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

    :param node: the controller's node.
    :param kind: the action type.
    :param name: the action's name.
    """

    def __init__(self, node: Node, dispatcher: Dispatcher, kind: type[Any], name: str) -> None:
        self._node = node
        self._dispatcher = dispatcher
        self._taken: tuple[Any, Any] | None = None
        self._discoveries = [
            ClientDiscovery(node, dispatcher, f'{name}/_action/{service}')
            for service in ('send_goal', 'cancel_goal', 'get_result')
        ]
        self._running: dict[bytes, RunningGoal] = {}
        self._ending = ''
        self._server = ActionServer(
            node,
            kind,
            name,
            execute_callback=self._execute,
            goal_callback=self._decide,
            handle_accepted_callback=self._accept,
            cancel_callback=self._cancel,
            **qos.ACTION_SERVICES,
            result_timeout=RESULT_TIMEOUT,
        )
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
        running.goal.add_done_callback(
            lambda _: self._dispatcher.post(lambda: self._end(running))
        )

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

    :param node: the controller's node.
    :param profile: how long a reason is there for late subscribers, among others.
    """

    def __init__(self, node: Node, profile: QoSProfile = qos.EVENTS) -> None:
        self._publisher = node.create_publisher(String, '~/rejected_goals', profile)

    def publish(self, reason: str) -> None:
        """Publish a reason."""
        self._publisher.publish(String(data=reason))
