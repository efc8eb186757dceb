# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The log of planning: any object with these three methods."""

from __future__ import annotations

from typing import Protocol


class Log(Protocol):
    """The part of ``logging.Logger`` (and of rclpy's logger) that is used here."""

    def info(self, message: str, /) -> object:
        """Log an event."""

    def warning(self, message: str, /) -> object:
        """Log a warning."""

    def error(self, message: str, /) -> object:
        """Log an error."""
