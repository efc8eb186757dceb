# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How move_group answers: action servers that keep few results, and errors as error codes."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
import traceback
from typing import Any

from moveit_msgs.msg import MoveItErrorCodes
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle

from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.nodes import qos
from armsim_ros.nodes.kept_results import KeptResults
from armsim_ros.nodes.move_group.context import Context


@contextmanager
def reported(logger: Any, source: str, error_code: MoveItErrorCodes | None) -> Iterator[None]:
    """
    Turn exceptions raised inside into the error code of an answer.

    :param logger: of the node.
    :param source: the endpoint, where the error does not name a stage itself.
    :param error_code: to be filled; None for an answer without.
    """
    try:
        yield
    except PlanningError as error:
        logger.error(f'{source}: {error}')
        fill_error(error_code, error.code, str(error), error.source or source)
    except Exception as error:  # noqa: BLE001 - no node dies of a message
        text = ''.join(traceback.format_exception(error))
        logger.error(f'{source}: internal error, please report it:\n{text}')
        fill_error(error_code, MoveItErrorCode.FAILURE, f'internal error: {error}', source)


def fill_error(
    error_code: MoveItErrorCodes | None, code: int, text: str = '', source: str = ''
) -> None:
    """Write a code, its sentence and its source into an answer."""
    if error_code is not None:
        error_code.val, error_code.message, error_code.source = int(code), text, source


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
