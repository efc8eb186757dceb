# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Results of action goals that have ended, kept for clients that ask late."""

from __future__ import annotations

from collections import deque

from action_msgs.msg import GoalStatus
from rclpy.action import ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.task import Future


class KeptResults:
    """
    The results of an action server: of the goals that ended last, and of no others.

    A client that requests a result that is no longer kept is answered that the goal is not known.

    :param server: whose ``result_timeout`` is in the node's time, as fast as that may run.
    :param most: how many are kept.
    """

    def __init__(self, server: ActionServer, most: int) -> None:
        self._server = server
        self._most = most
        self._ended: deque[ServerGoalHandle] = deque()

    def add(self, goal: ServerGoalHandle) -> None:
        """Keep the result of a goal that ends now; of those before, the requests no longer."""
        if self._ended:
            self._ended[-1]._goal_request = None
        self._ended.append(goal)
        while len(self._ended) > self._most:
            self._forget(self._ended.popleft())

    def _forget(self, goal: ServerGoalHandle) -> None:
        """Let go of the messages of a goal whose result was sent long ago; rclpy never does."""
        server, key = self._server, bytes(goal.goal_id.uuid)
        if key not in server._result_futures:
            return  # its time was up
        unknown = server._action_type.Impl.GetResultService.Response()
        unknown.status = GoalStatus.STATUS_UNKNOWN
        forgotten = Future()
        forgotten.set_result(unknown)
        server.remove_future(server._result_futures[key])
        server._result_futures[key] = forgotten
        server.add_future(forgotten)
