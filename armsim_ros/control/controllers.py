# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a control loop calls: the controllers of a robot, or of several."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol


class Controllers(Protocol):
    """
    Controllers that a control loop updates; the controller manager is an implementation.

    An update can be left out where its commands are known beforehand. ``plan`` returns how many
    updates from now on are of this kind; until ``pass_updates`` closes the plan, only
    ``next_reading`` and ``read`` are called, with numbers of updates that count from its first.
    """

    def update(self, time_ns: int, period: float, /) -> object:
        """Read states and write commands for the next period [s]."""

    def plan(self, updates: int, time_ns: int, period: float, *, moving: bool) -> int:
        """
        Return for how many updates ahead all commands are known.

        :param updates: that may be planned, at least 1.
        :param time_ns: the time of the first of them [ns].
        :param period: from each to the next [s].
        :param moving: whether commands may change; they are written into the hardware's ``plan``
            then. Otherwise only updates that change no command are planned.
        :returns: 0 where the next update must be made.
        """

    def next_reading(self, update: int, updates: int) -> int:
        """
        Return the next update of the plan at which a controller has to read states.

        :param update: the first that may be it.
        :param updates: what is returned where none before it does.
        """

    def read(self, update: int) -> bool:
        """Have states read at an update of the plan; return whether no controller failed."""

    def pass_updates(self, updates: int, period: float) -> None:
        """Be where so many updates of the plan, a period [s] apart, have led."""

    def process_requests(self, time_ns: int, /) -> object:
        """Take up switches, goals and cancels without moving time."""

    def interrupt(self, time_ns: int, reason: str) -> None:
        """End all goals before the plant is put elsewhere."""

    def resume(self, time_ns: int) -> None:
        """Have the active controllers take over the plant where it is now."""

    def wake_with(self, wake: Callable[[], object]) -> None:
        """Have a function called when there is something new for the next update."""
