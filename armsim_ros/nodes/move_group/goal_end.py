# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How an action goal ends, by its error code."""

from __future__ import annotations

from rclpy.action.server import ServerGoalHandle

from armsim_ros.planning.error_codes import MoveItErrorCode


def end_goal(goal: ServerGoalHandle, code: int) -> None:
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
