# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What other threads leave in a trajectory controller's mailbox for its control loop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsim_ros.control.trajectory.goal import TrajectoryGoal
from armsim_ros.control.trajectory.sampling import PreparedTrajectory
from armsim_ros.control.trajectory.tolerances import SegmentTolerances


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
