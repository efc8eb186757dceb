# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The controller managers of several robots, run as one."""

from __future__ import annotations

from collections.abc import Sequence

from armsim_ros.control.controller_manager import ControllerManager


class ManagerGroup:
    """
    Updates one manager after the other; a control loop takes it as it takes a manager.

    :param managers: of the robots.
    """

    def __init__(self, managers: Sequence[ControllerManager]) -> None:
        """Keep the managers."""
        self._managers = tuple(managers)

    def update(self, time_ns: int, period: float) -> None:
        """Update the controllers of all robots."""
        for manager in self._managers:
            manager.update(time_ns, period)

    def process_requests(self, time_ns: int) -> None:
        """Take requests up while time stands still."""
        for manager in self._managers:
            manager.process_requests(time_ns)
