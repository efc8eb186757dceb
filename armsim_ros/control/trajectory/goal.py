# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Goals of actions and how they end.

A goal is made in the thread that sends it and ended in the control loop's thread. Its status is
read from any thread. Callbacks run in the thread that ends the goal: they must only hand over.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
import threading
from typing import Generic, TypeVar

from armsim_ros.control.trajectory.tolerances import SegmentTolerances
from armsim_ros.errors import ControllerError
from armsim_ros.trajectory import JointTrajectory


class GoalStatus(IntEnum):
    """Life of a goal, with the values of ``action_msgs/msg/GoalStatus``."""

    ACCEPTED = 1
    EXECUTING = 2
    CANCELING = 3
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6


class TrajectoryErrorCode(IntEnum):
    """Codes of ``control_msgs/action/FollowJointTrajectory``'s result."""

    SUCCESSFUL = 0
    INVALID_GOAL = -1
    INVALID_JOINTS = -2
    OLD_HEADER_TIMESTAMP = -3
    PATH_TOLERANCE_VIOLATED = -4
    GOAL_TOLERANCE_VIOLATED = -5


@dataclass(frozen=True, slots=True)
class TrajectoryResult:
    """How a trajectory goal ended; the message is empty only for a cancel."""

    code: TrajectoryErrorCode
    message: str = ''


class RefusedTrajectoryError(ControllerError):
    """
    A trajectory is not taken.

    :param reason: one sentence that names joint, point, value and what is allowed.
    :param code: the result code that fits.
    """

    def __init__(
        self, reason: str, code: TrajectoryErrorCode = TrajectoryErrorCode.INVALID_GOAL
    ) -> None:
        super().__init__(reason)
        self.reason = reason
        self.code = code


ResultT = TypeVar('ResultT')


class ActionGoal(Generic[ResultT]):
    """One goal of an action; it ends exactly once."""

    def __init__(self) -> None:
        self.status = GoalStatus.ACCEPTED
        self.result: ResultT | None = None
        self.cancel_requested = False
        self._lock = threading.Lock()
        self._callbacks: list[Callable[[ActionGoal[ResultT]], None]] = []

    @property
    def done(self) -> bool:
        """Whether the goal has ended; its result is there then."""
        return self.status >= GoalStatus.SUCCEEDED

    def add_done_callback(self, callback: Callable[[ActionGoal[ResultT]], None]) -> None:
        """Call back once when the goal ends; at once where it has ended already."""
        with self._lock:
            if not self.done:
                self._callbacks.append(callback)
                return
        callback(self)

    def execute(self) -> None:
        """Note that the control loop has taken the goal up."""
        with self._lock:
            if self.status is GoalStatus.ACCEPTED:
                self.status = GoalStatus.EXECUTING

    def request_cancel(self) -> bool:
        """Note that a client wants to cancel; False where the goal has ended."""
        with self._lock:
            if self.done:
                return False
            self.cancel_requested = True
            self.status = GoalStatus.CANCELING
            return True

    def finish(self, status: GoalStatus, result: ResultT) -> bool:
        """End the goal; False, and no change, where it has ended before."""
        with self._lock:
            if self.done:
                return False
            self.result = result
            self.status = status
            callbacks, self._callbacks = self._callbacks, []
        for callback in callbacks:
            callback(self)
        return True


class TrajectoryGoal(ActionGoal[TrajectoryResult]):
    """
    A trajectory that a client follows to its end.

    :param trajectory: as the client sent it.
    :param tolerances: for this goal alone.
    """

    def __init__(self, trajectory: JointTrajectory, tolerances: SegmentTolerances) -> None:
        super().__init__()
        self.trajectory = trajectory
        self.tolerances = tolerances


@dataclass(frozen=True, slots=True)
class GoalResponse:
    """
    The answer to a goal.

    :param reason: why it was refused; it is there too where a refused goal is accepted only to
        be aborted, so that its result can tell the reason.
    """

    accepted: bool
    reason: str = ''
    code: TrajectoryErrorCode = TrajectoryErrorCode.SUCCESSFUL
    goal: TrajectoryGoal | None = None
