# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The controller managers of several robots, run together."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from armsim_ros.control.manager.controller_manager import ControllerManager


class ManagerGroup:
    """
    The managers of several robots, see :class:`Controllers`; each call goes to all of them.

    :param managers: of the robots.
    """

    def __init__(self, managers: Sequence[ControllerManager]) -> None:
        self._managers = tuple(managers)

    def update(self, time_ns: int, period: float) -> None:
        """Update the controllers of all robots."""
        for manager in self._managers:
            manager.update(time_ns, period)

    def plan(self, updates: int, time_ns: int, period: float, *, moving: bool) -> int:
        """Plan updates of all robots' controllers; return how many all of them know."""
        moves = not moving
        for manager in self._managers:
            known = manager.plan(updates, time_ns, period, moving=moving)
            moves = moves or known > 0
            # A robot may be at rest while another moves.
            updates = known or manager.plan(updates, time_ns, period, moving=False)
            if not updates:
                return 0
        return updates if moves else 0

    def next_reading(self, update: int, updates: int) -> int:
        """Return the next update of the plan at which any of them reads states."""
        return min(manager.next_reading(update, updates) for manager in self._managers)

    def read(self, update: int) -> bool:
        """Have states read at an update of the plan; return whether no controller failed."""
        return all(manager.read(update) for manager in self._managers)

    def pass_updates(self, updates: int, period: float) -> None:
        """Be where so many updates of the plan have led."""
        for manager in self._managers:
            manager.pass_updates(updates, period)

    def process_requests(self, time_ns: int) -> None:
        """Take requests up while time is paused."""
        for manager in self._managers:
            manager.process_requests(time_ns)

    def interrupt(self, time_ns: int, reason: str) -> None:
        """End the goals of all robots' controllers."""
        for manager in self._managers:
            manager.interrupt(time_ns, reason)

    def resume(self, time_ns: int) -> None:
        """Have all robots' controllers take over the plant where it is now."""
        for manager in self._managers:
            manager.resume(time_ns)

    def wake_with(self, wake: Callable[[], object]) -> None:
        """Have a function called when there is something new for the next update."""
        for manager in self._managers:
            manager.wake_with(wake)
