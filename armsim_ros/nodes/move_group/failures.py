# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A request's errors become its error code and a log line; none of them ends the node."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import traceback
from typing import Any

from moveit_msgs.msg import MoveItErrorCodes

from armsim_ros.errors import MoveItErrorCode, PlanningError


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
