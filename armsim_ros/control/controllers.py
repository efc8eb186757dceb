# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The controllers that a control loop calls: of a robot, or of several."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from armsim_ros.control.manager.controller_manager import ControllerManager


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
