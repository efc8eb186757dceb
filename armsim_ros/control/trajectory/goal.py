# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Goals of trajectory controllers and how they end."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from armsim_ros.control.action_goal import ActionGoal
from armsim_ros.control.trajectory.tolerances import SegmentTolerances
from armsim_ros.errors import ControllerError
from armsim_ros.trajectory import JointTrajectory


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

    :param reason: a sentence that names joint, point, value and what is allowed.
    :param code: the result code that fits.
    """

    def __init__(
        self, reason: str, code: TrajectoryErrorCode = TrajectoryErrorCode.INVALID_GOAL
    ) -> None:
        super().__init__(reason)
        self.reason = reason
        self.code = code


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
        be aborted, so that its result can give the reason.
    """

    accepted: bool
    reason: str = ''
    code: TrajectoryErrorCode = TrajectoryErrorCode.SUCCESSFUL
    goal: TrajectoryGoal | None = None
