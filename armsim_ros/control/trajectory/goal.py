# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Goals of trajectory controllers: requests, how they end, and whether they are reached."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Matrix
from armsim_ros.control.mailbox import ActionGoal
from armsim_ros.control.trajectory.sampling import PreparedTrajectory, TIME_RESOLUTION
from armsim_ros.control.trajectory.tolerances import SegmentTolerances, ToleranceCheck
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
        self.reason, self.code = reason, code


class TrajectoryGoal(ActionGoal[TrajectoryResult]):
    """
    A trajectory that a client follows to its end.

    :param trajectory: as the client sent it.
    :param tolerances: for this goal alone.
    """

    def __init__(self, trajectory: JointTrajectory, tolerances: SegmentTolerances) -> None:
        super().__init__()
        self.trajectory, self.tolerances = trajectory, tolerances


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

    @property
    def start_ns(self) -> int:
        """From when on the joints follow it [ns], 0 for at once."""
        return self.prepared.start_ns(self.stamp_ns)


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
        elif request.start_ns <= time_ns:
            any_follows = True
            goal_follows = request.goal is not None
    return passed


class Verdict(NamedTuple):
    """How a trajectory ends, and the sentence for its client."""

    code: TrajectoryErrorCode
    text: str


#: A goal without a tolerance ends with a warning where a joint is farther from it [rad or m].
ARRIVED = 5e-3
SUCCESS = Verdict(TrajectoryErrorCode.SUCCESSFUL, 'Goal reached: success')


class ToleranceMonitor:
    """
    Checks a trajectory, update by update.

    The path is checked until the last waypoint, and once at the first update in any case. From
    the last waypoint on the trajectory succeeds as soon as every joint is inside its goal
    tolerance at the same time, and fails when that takes longer than the goal time.

    :param joints: names for the sentences.
    :param computed: which of position, velocity, acceleration have an error.
    :param strict: goal time 0 leaves no time at all instead of any.
    """

    def __init__(
        self, joints: Sequence[str], computed: Sequence[bool], tolerances: SegmentTolerances, *,
        strict: bool
    ) -> None:
        self.path = ToleranceCheck(joints, tolerances.path, computed)
        self._goal = ToleranceCheck(joints, tolerances.goal, computed)
        self._joints = tuple(joints)
        self._unchecked = ~np.isfinite(tolerances.goal[0])
        self._goal_time = tolerances.goal_time
        self._strict = strict
        self.first = True
        """Whether nothing was checked yet."""

    @property
    def can_fail_at_end(self) -> bool:
        """Whether errors after the last waypoint can end the trajectory."""
        return self._goal.checks and (self._strict or self._goal_time > 0.0)

    def missed(self, errors: Matrix) -> str:
        """
        Return which joint without a goal tolerance is farthest from the last point, '' for none.

        :param errors: (3, n) reference minus feedback.
        """
        distances = np.where(self._unchecked, np.abs(errors[0]), 0.0)
        worst = int(distances.argmax())
        if not distances[worst] > ARRIVED:
            return ''
        return (f"joint '{self._joints[worst]}' is {distances[worst]:.3g} from its last point; "
                f'constraints.{self._joints[worst]}.goal makes the controller check that')

    def check(self, errors: Matrix, over: float) -> Verdict | None:
        """
        Return the verdict, None while there is none.

        :param errors: (3, n) reference minus feedback.
        :param over: time since the last waypoint, negative before it [s].
        """
        before_end = over < -TIME_RESOLUTION
        if (before_end or self.first) and self.path.violated(errors):
            return Verdict(
                TrajectoryErrorCode.PATH_TOLERANCE_VIOLATED,
                f'path tolerance violated: {self.path.worst(errors)}')
        self.first = False
        if before_end:
            return None
        if not self._goal.violated(errors):
            return SUCCESS
        without_grace = self._strict and self._goal_time == 0.0
        if without_grace or 0.0 < self._goal_time < over - TIME_RESOLUTION:
            return Verdict(
                TrajectoryErrorCode.GOAL_TOLERANCE_VIOLATED,
                f'goal_time_tolerance exceeded: {over:.6f} s after the last waypoint (allowed '
                f'{self._goal_time:g} s) {self._goal.worst(errors)}')
        return None


def timed_out(over: float, timeout: float) -> Verdict | None:
    """
    Return the verdict that no new command came for too long, else None.

    :param over: time since the last waypoint [s].
    :param timeout: 0 is never [s].
    """
    if not 0.0 < timeout < over - TIME_RESOLUTION:
        return None
    return Verdict(
        TrajectoryErrorCode.GOAL_TOLERANCE_VIOLATED,
        f'cmd_timeout exceeded: no new command for {over:.6f} s after the last waypoint, allowed '
        f'{timeout:g} s')
