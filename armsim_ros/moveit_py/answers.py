# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How a plan and how an execution ended."""

from __future__ import annotations

from moveit_msgs.msg import MoveItErrorCodes
from moveit_msgs.msg import RobotState as RobotStateMessage

from armsim_ros.errors import MoveItErrorCode
from armsim_ros.moveit_py.robot_trajectory import RobotTrajectory


class MotionPlanResponse:
    """
    The answer to a planning request; true where there is a plan.

    :param trajectory: None where there is no plan.
    :param error_code: with a sentence where the request failed.
    :param planning_time: [s].
    :param start_state: where the trajectory begins.
    :param planner_id: that was requested.
    """

    def __init__(
        self, trajectory: RobotTrajectory | None, error_code: MoveItErrorCodes,
        planning_time: float = 0.0, start_state: RobotStateMessage | None = None,
        planner_id: str = ''
    ) -> None:
        self._trajectory, self._error_code = trajectory, error_code
        self._planning_time, self._planner_id = planning_time, planner_id
        self._start_state = RobotStateMessage() if start_state is None else start_state

    @property
    def trajectory(self) -> RobotTrajectory | None:
        """The plan, None where there is none."""
        return self._trajectory

    @property
    def planning_time(self) -> float:
        """Time for the search [s]."""
        return self._planning_time

    @property
    def error_code(self) -> MoveItErrorCodes:
        """The code, and a sentence where the request failed."""
        return self._error_code

    @property
    def start_state(self) -> RobotStateMessage:
        """Where the trajectory begins."""
        return self._start_state

    @property
    def planner_id(self) -> str:
        """The planner that was requested."""
        return self._planner_id

    def __bool__(self) -> bool:
        """Return whether there is a plan."""
        return bool(self._error_code.val == MoveItErrorCodes.SUCCESS)


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
