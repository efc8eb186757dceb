# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Updates that a manager need not make one by one: which of them read states all the same."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from armsim_ros.control.controller import Controller

Active = Sequence[tuple[Controller[Any], int]]
"""Active controllers, each with the updates of the manager from one of its own to the next."""


class UpdatesAhead:
    """
    Some updates ahead, by their number from 0.

    :param lookers: controllers that only read states.
    :param tick: number of the first update since the manager began.
    :param time_ns: its time [ns].
    :param period: from one to the next [s].
    :param planners: those that know their commands of all these updates.
    """

    def __init__(
        self,
        lookers: Active,
        tick: int,
        time_ns: int,
        period: float,
        planners: Sequence[Controller[Any]] = (),
    ) -> None:
        self.planners = planners
        self.period = period
        self._lookers = lookers
        self._tick = tick
        self._time_ns = time_ns

    @property
    def lookers(self) -> Sequence[Controller[Any]]:
        """Controllers that only read states."""
        return [controller for controller, _ in self._lookers]

    def next_look(self, update: int, updates: int) -> int:
        """
        Return the next update at which a controller reads states.

        :param update: the first that may be it.
        :param updates: what is returned where none before it does.
        """
        period_ns = self.period * 1e9
        time_ns = self._time_ns + round(update * period_ns)
        for controller, divisor in self._lookers:
            wait_ns = controller.next_update(time_ns) - time_ns
            first = update + max(0, int(-(-wait_ns // period_ns)))
            # Its updates are those whose numbers are multiples of the divisor.
            updates = min(updates, first + -(self._tick + first) % divisor)
        return updates

    def look(self, update: int, failures: dict[str, Exception]) -> None:
        """
        Update those who only read states, at an update where one of them has to.

        :param failures: controller -> what it has raised; those that have are left out.
        """
        time_ns = self._time_ns + round(update * self.period * 1e9)
        for controller, divisor in self._lookers:
            if (self._tick + update) % divisor or controller.name in failures:
                continue
            try:
                controller.update(time_ns, self.period * divisor)
            except Exception as error:  # noqa: BLE001 - one controller must not stop the others
                failures[controller.name] = error


def planned_updates(
    active: Active, updates: int, tick: int, time_ns: int, period: float
) -> tuple[int, UpdatesAhead]:
    """
    Have updates ahead planned, see :meth:`Controller.plan`; parameters as for the manager.

    :returns: how many are, 0 where a controller that matters does not know, and what they are.
    """
    planners: list[Controller[Any]] = []
    lookers = [(controller, divisor) for controller, divisor in active if controller.only_looks]
    ahead = UpdatesAhead(lookers, tick, time_ns, period, planners)
    for controller, divisor in active:
        if controller.only_looks:
            continue
        wait_ns = controller.next_update(time_ns) - time_ns
        if wait_ns > 0:
            updates = int(min(updates, -(-wait_ns // (period * 1e9))))
        elif divisor == 1:
            planners.append(controller)
        else:
            return 0, ahead
    for controller in planners:
        updates = updates and controller.plan(updates, period)
    return (updates if planners else 0), ahead
