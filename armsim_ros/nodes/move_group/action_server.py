# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Action servers of move_group: every goal and every cancel is accepted, results are few."""

from __future__ import annotations

from collections import deque
from collections.abc import Awaitable, Callable
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.task import Future

from armsim_ros.errors import MoveItErrorCode
from armsim_ros.nodes import qos
from armsim_ros.nodes.move_group.context import Context

#: How long a result waits for a client that asks late [s], and how many of them wait at most.
RESULT_TIMEOUT, MOST_RESULTS = 60, 50


class MoveGroupActionServer(ActionServer):
    """
    Accepts everything, and keeps the results of ended goals for a while.

    Whoever asks for a result that is kept no more is told that the goal is not known.

    :param context: the parts of move_group.
    :param execute: goal handle -> result; it calls :meth:`end` at last.
    """

    def __init__(
        self, context: Context, kind: Any, name: str,
        execute: Callable[[ServerGoalHandle], Awaitable[Any]],
    ) -> None:
        super().__init__(
            context.node,
            kind,
            name,
            execute,
            callback_group=context.group,
            cancel_callback=lambda goal: CancelResponse.ACCEPT,
            result_timeout=RESULT_TIMEOUT,
            **qos.ACTION_SERVICES,
        )
        self._ended: deque[ServerGoalHandle] = deque()

    def end(self, goal: ServerGoalHandle, code: int) -> None:
        """
        Give a goal its terminal status.

        SUCCESS succeeds; PREEMPTED after a cancel request is canceled; all else is aborted.
        """
        if code == MoveItErrorCode.SUCCESS:
            goal.succeed()
        elif code == MoveItErrorCode.PREEMPTED and goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()
        self._ended.append(goal)
        while len(self._ended) > MOST_RESULTS:
            self._forget(self._ended.popleft())

    def _forget(self, goal: ServerGoalHandle) -> None:
        """Let go of the messages of a goal whose result was sent long ago; rclpy never does."""
        key = bytes(goal.goal_id.uuid)
        if key not in self._result_futures:
            return  # its time was up
        unknown = self._action_type.Impl.GetResultService.Response()
        unknown.status = GoalStatus.STATUS_UNKNOWN
        forgotten = Future()
        forgotten.set_result(unknown)
        self.remove_future(self._result_futures[key])
        self._result_futures[key] = forgotten
        self.add_future(forgotten)
        goal._goal_request = None
