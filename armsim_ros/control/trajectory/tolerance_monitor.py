# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a trajectory is kept on the way and reached at its end."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.control.trajectory.goal import TrajectoryErrorCode
from armsim_ros.control.trajectory.sampling import TIME_RESOLUTION
from armsim_ros.control.trajectory.tolerances import SegmentTolerances, ToleranceCheck


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
        self,
        joints: Sequence[str],
        computed: Sequence[bool],
        tolerances: SegmentTolerances,
        *,
        strict: bool,
    ) -> None:
        self.path = ToleranceCheck(joints, tolerances.path, computed)
        self._goal = ToleranceCheck(joints, tolerances.goal, computed)
        self._joints = tuple(joints)
        self._unchecked = ~np.isfinite(tolerances.goal[0])
        self._goal_time = tolerances.goal_time
        self._strict = strict
        self._first = True

    @property
    def first(self) -> bool:
        """Whether nothing was checked yet."""
        return self._first

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
        if (before_end or self._first) and self.path.violated(errors):
            return Verdict(
                TrajectoryErrorCode.PATH_TOLERANCE_VIOLATED,
                f'path tolerance violated: {self.path.worst(errors)}',
            )
        self._first = False
        if before_end:
            return None
        if not self._goal.violated(errors):
            return SUCCESS
        without_grace = self._strict and self._goal_time == 0.0
        if without_grace or 0.0 < self._goal_time < over - TIME_RESOLUTION:
            return Verdict(
                TrajectoryErrorCode.GOAL_TOLERANCE_VIOLATED,
                f'goal_time_tolerance exceeded: {over:.6f} s after the last waypoint (allowed '
                f'{self._goal_time:g} s) {self._goal.worst(errors)}',
            )
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
        f'{timeout:g} s',
    )
