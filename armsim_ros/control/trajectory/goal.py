# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Goals of trajectory controllers, how they end, and requests to the control loop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from armsim_ros.control.mailbox import ActionGoal
from armsim_ros.control.trajectory.sampling import PreparedTrajectory
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


@dataclass(frozen=True, slots=True, eq=False)
class TrajectoryStart:
    """
    From where the joints begin to follow a trajectory.

    :param measured: (n,) joints that begin where they are, not where they should be: something
        keeps them away from there.
    :param jump: whether a first point at time 0 is jumped to.
    """

    measured: NDArray[np.bool_]
    jump: bool


@dataclass(frozen=True, slots=True, eq=False)
class StartRequest:
    """
    Follow a trajectory.

    :param goal: None for a trajectory from the topic.
    :param start: None is where the joints should be.
    """

    prepared: PreparedTrajectory
    stamp_ns: int
    tolerances: SegmentTolerances
    goal: TrajectoryGoal | None = None
    start: TrajectoryStart | None = None


@dataclass(frozen=True, slots=True)
class CancelRequest:
    """Cancel a goal; None cancels whatever is active."""

    goal: TrajectoryGoal | None


@dataclass(frozen=True, slots=True)
class StopRequest:
    """Stop and cancel what is active; a goal that asked for it has succeeded then."""

    goal: TrajectoryGoal | None


Request = StartRequest | CancelRequest | StopRequest


def superseded(requests: Sequence[Request], time_ns: int) -> dict[int, StartRequest]:
    """
    Return the trajectories that are replaced before they have moved anything, by their index.

    That is every trajectory before a goal that starts at once, and every trajectory of the topic
    before any that starts at once.

    :param requests: in the order in which they came.
    """
    passed: dict[int, StartRequest] = {}
    goal_follows = any_follows = False
    for i in range(len(requests) - 1, -1, -1):
        request = requests[i]
        if not isinstance(request, StartRequest):
            continue
        if goal_follows or (any_follows and request.goal is None):
            passed[i] = request
        elif request.stamp_ns <= time_ns:
            any_follows = True
            goal_follows = request.goal is not None
    return passed
