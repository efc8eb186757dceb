# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The time that a request has left, spent on a shorter path."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from armsim_ros.errors import PlanningError
from armsim_ros.planning.error_codes import MoveItErrorCode
from armsim_ros.planning.quintic import QuinticMotion
from armsim_ros.planning.search import Budget
from armsim_ros.planning.smoothing import path_length

Vector = NDArray[np.float64]
Found = tuple[Vector, QuinticMotion]

RESERVE = 2.0
"""No search begins where less time is left than so many of the longest one so far."""


def shortest_in_time(
    first: Found, search: Callable[[], Found], budget: Budget
) -> Found:
    """
    Search again and again until the time is over; return the shortest path of all.

    :param first: path and motion that were found.
    :param search: returns others, by other chances.
    :param budget: the request's.
    :raises PlanningError: PREEMPTED where the request is cancelled.
    """
    best, longest = first, 0.0
    while not budget.spent() and budget.clock() + RESERVE * longest < budget.deadline:
        began = budget.clock()
        try:
            other = search()
        except PlanningError as error:
            if error.code == MoveItErrorCode.PREEMPTED:
                raise
        else:
            if path_length(other[0]) < path_length(best[0]):
                best = other
        longest = max(longest, budget.clock() - began)
    budget.check('anytime')
    return best
