# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Replaces a controller that only its vendor has: it can be activated and does nothing."""

from __future__ import annotations

from typing import ClassVar

from armsim_ros.config.base import Settings
from armsim_ros.config.controllers.stand_in import StandInParameters
from armsim_ros.control.controller import Controller


class StandInController(Controller[StandInParameters]):
    """Claims nothing and commands nothing; its life cycle is that of any controller."""

    parameters_class: ClassVar[type[Settings]] = StandInParameters

    @property
    def joints(self) -> tuple[str, ...]:
        """None."""
        return ()

    @property
    def required_command_interfaces(self) -> tuple[str, ...]:
        """None: nothing is commanded."""
        return ()

    @property
    def required_state_interfaces(self) -> tuple[str, ...]:
        """None: nothing is read."""
        return ()

    def configure(self) -> None:
        """Do nothing."""

    def activate(self, time_ns: int) -> None:
        """Do nothing."""

    def deactivate(self, time_ns: int) -> None:
        """Do nothing."""

    def update(self, time_ns: int, period: float) -> None:
        """Do nothing."""

    def process_requests(self, time_ns: int) -> None:
        """Do nothing: there are no requests."""
