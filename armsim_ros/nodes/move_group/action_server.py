# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""move_group's action servers: goals and cancels are always accepted, few results are kept."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle

from armsim_ros.errors import MoveItErrorCode
from armsim_ros.nodes import qos
from armsim_ros.nodes.kept_results import KeptResults
from armsim_ros.nodes.move_group.context import Context

#: How long results are kept for clients that ask late [s], and how many of them.
RESULT_TIMEOUT, MOST_RESULTS = 60, 50


class MoveGroupActionServer(ActionServer):
    """
    Accepts every goal and keeps the results of those that ended last.

    :param context: the parts of move_group.
    :param execute: goal handle -> result; it calls :meth:`end` at last.
    """

    def __init__(
        self, context: Context, kind: Any, name: str,
        execute: Callable[[ServerGoalHandle], Awaitable[Any]],
    ) -> None:
        super().__init__(  # type: ignore[no-untyped-call] # rclpy's
            context.node,
            kind,
            name,
            execute,
            callback_group=context.group,
            cancel_callback=lambda goal: CancelResponse.ACCEPT,
            result_timeout=RESULT_TIMEOUT,
            **qos.ACTION_SERVICES,
        )
        self._results = KeptResults(self, MOST_RESULTS)

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
        self._results.add(goal)
