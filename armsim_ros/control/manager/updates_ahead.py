# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Updates that a manager need not make: how many they are, and which of them read states."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from armsim_ros.control.controller import Controller


class UpdatesAhead:
    """
    The next updates of a manager, by their number from 0.

    :param active: controllers, each with the manager's updates per update of its own.
    :param tick: number of the first update since the manager began.
    :param time_ns: its time [ns].
    :param period: from each to the next [s].
    """

    def __init__(
        self, active: Sequence[tuple[Controller[Any], int]], tick: int, time_ns: int, period: float
    ) -> None:
        self._readers = [entry for entry in active if entry[0].only_reads]
        self._others = [entry for entry in active if not entry[0].only_reads]
        self._tick = tick
        self._time_ns = time_ns
        self._period = period

    def plan(self, updates: int, *, moving: bool) -> int:
        """Plan updates, see :meth:`Controllers.plan`."""
        planners: list[Controller[Any]] = []
        for controller, divisor in self._others:
            if (wait := self._wait(controller, 0)) > 0:
                updates = min(updates, wait)
            elif moving and divisor == 1:
                planners.append(controller)
            else:
                return 0
        if moving and not planners:
            return 0
        for controller in planners:
            updates = updates and controller.plan(updates, self._period)
        return updates

    def next_reading(self, update: int, updates: int) -> int:
        """Return when states are read, see :meth:`Controllers.next_reading`."""
        for controller, divisor in self._readers:
            first = update + self._wait(controller, update)
            # Its updates are those whose numbers are multiples of the divisor.
            updates = min(updates, first + -(self._tick + first) % divisor)
        return updates

    def read(self, update: int, failures: dict[str, Exception]) -> None:
        """
        Update the controllers that only read states.

        :param failures: controller -> what it has raised; those that have are left out.
        """
        time_ns = self.time_ns(update)
        for controller, divisor in self._readers:
            if (self._tick + update) % divisor or controller.name in failures:
                continue
            try:
                controller.update(time_ns, self._period * divisor)
            except Exception as error:  # noqa: BLE001 - one controller must not stop the others
                failures[controller.name] = error

    def time_ns(self, update: int) -> int:
        """Return the time of an update [ns]."""
        return self._time_ns + round(update * self._period * 1e9)

    def _wait(self, controller: Controller[Any], update: int) -> int:
        """Return how many updates from the present on do not matter to a controller."""
        period_ns = self._period * 1e9
        time_ns = self._time_ns + round(update * period_ns)
        return max(0, int(-((time_ns - controller.next_update(time_ns)) // period_ns)))
