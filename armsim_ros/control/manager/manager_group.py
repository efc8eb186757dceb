# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The controller managers of several robots, run as one."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from armsim_ros.control.manager.controller_manager import ControllerManager


class ManagerGroup:
    """
    Updates one manager after the other; a control loop takes it as it takes a manager.

    :param managers: of the robots.
    """

    def __init__(self, managers: Sequence[ControllerManager]) -> None:
        self._managers = tuple(managers)

    def update(self, time_ns: int, period: float) -> None:
        """Update the controllers of all robots."""
        for manager in self._managers:
            manager.update(time_ns, period)

    def process_requests(self, time_ns: int) -> None:
        """Take requests up while time stands still."""
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

    def next_update(self, time_ns: int) -> int:
        """Return from when on an update of any of them matters [ns]."""
        return min(manager.next_update(time_ns) for manager in self._managers)

    def plan(self, updates: int, time_ns: int, period: float) -> int:
        """Plan updates of all robots' controllers; return how many all of them know."""
        for manager in self._managers:
            updates = manager.plan(updates, time_ns, period)
            if not updates:
                break
        return updates

    def next_look(self, update: int, updates: int) -> int:
        """Return the next update of the plan at which any of them reads states."""
        return min(manager.next_look(update, updates) for manager in self._managers)

    def look(self, update: int) -> bool:
        """Have the states read at an update of the plan; return whether nobody failed."""
        return all(manager.look(update) for manager in self._managers)

    def land(self, updates: int) -> None:
        """Be where so many updates of the plan have led."""
        for manager in self._managers:
            manager.land(updates)

    def only_looks(self, time_ns: int) -> bool:
        """Return whether an update now would do nothing but read states."""
        return all(manager.only_looks(time_ns) for manager in self._managers)

    def glance(self, time_ns: int, period: float) -> None:
        """Do an update of which nothing matters but that states are read."""
        for manager in self._managers:
            manager.glance(time_ns, period)

    def look_early(self, time_ns: int, period: float) -> None:
        """Have the states read; the update of this time is still to come."""
        for manager in self._managers:
            manager.look_early(time_ns, period)

    def skip(self, updates: int, period: float) -> None:
        """Take note of updates that were left out."""
        for manager in self._managers:
            manager.skip(updates, period)

    def wake_with(self, wake: Callable[[], object]) -> None:
        """Have a function called when there is something new for the next update."""
        for manager in self._managers:
            manager.wake_with(wake)
