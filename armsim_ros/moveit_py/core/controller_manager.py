# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``moveit.core.controller_manager``: how an execution ended."""

from __future__ import annotations

from armsim_ros.errors import MoveItErrorCode

_OF_CODES = {
    MoveItErrorCode.SUCCESS: 'SUCCEEDED',
    MoveItErrorCode.PREEMPTED: 'PREEMPTED',
    MoveItErrorCode.TIMED_OUT: 'TIMED_OUT',
}


class ExecutionStatus:
    """
    How the execution of a trajectory ended; true where the robot arrived.

    :param status: SUCCEEDED, PREEMPTED, TIMED_OUT, ABORTED, FAILED, RUNNING or UNKNOWN.
    """

    def __init__(self, status: str = 'UNKNOWN') -> None:
        self._status = status

    @classmethod
    def _of(cls, code: MoveItErrorCode) -> ExecutionStatus:
        return cls(_OF_CODES.get(code, 'ABORTED'))

    @property
    def status(self) -> str:
        """The status in capitals."""
        return self._status

    def __bool__(self) -> bool:
        """Return whether the robot arrived."""
        return self._status == 'SUCCEEDED'

    def __repr__(self) -> str:
        """Return the status in brackets."""
        return f'<ExecutionStatus {self._status}>'
