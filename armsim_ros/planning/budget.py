# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When a request ends: deadline, cancel, and a clock that counts its calls."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
import math

from armsim_ros.errors import MoveItErrorCode, PlanningError

Poll = Callable[[], None]
"""Called now and then within long checks; raises what ends the request."""


POLLED_STATES = {False: 50, True: 1}
"""States that are checked between two polls: on hulls, on exact shapes."""


def nothing() -> None:
    """Do nothing: the request cannot be cancelled."""


@dataclass(frozen=True, slots=True)
class Budget:
    """
    When a request has to end.

    :param clock: returns the time [s].
    :param deadline: in the clock's time [s].
    :param cancelled: returns whether the client has lost interest.
    """

    clock: Callable[[], float]
    deadline: float
    cancelled: Callable[[], bool]

    def spent(self) -> bool:
        """Return whether to stop."""
        return self.cancelled() or self.clock() >= self.deadline

    def now(self) -> float:
        """Return the clock's time [s], infinite if the request was cancelled."""
        return math.inf if self.cancelled() else self.clock()

    def check(self, stage: str) -> None:
        """Raise PREEMPTED where the request was cancelled."""
        if self.cancelled():
            raise PlanningError(
                MoveItErrorCode.PREEMPTED, 'the request was cancelled while planning', stage)


#: Time that passes at each look [s].
TICK = 1e-4


class CountingClock:
    """
    A clock that counts how often it is read.

    A planner that takes its time from it does the same work on every machine and at any load.
    """

    def __init__(self) -> None:
        self._looks = 0

    def __call__(self) -> float:
        """Return the time [s]; it is later each time."""
        self._looks += 1
        return self._looks * TICK
