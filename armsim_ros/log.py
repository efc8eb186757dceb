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


class DelayedLog:
    """Keeps lines until it is known whether they matter, and passes them to a log then."""

    def __init__(self) -> None:
        self._lines: list[tuple[str, str]] = []
        self._log: Log | None = None

    def info(self, message: str, /) -> None:
        """Log an event."""
        self._add('info', message)

    def warning(self, message: str, /) -> None:
        """Log a warning."""
        self._add('warning', message)

    def error(self, message: str, /) -> None:
        """Log an error."""
        self._add('error', message)

    def pass_to(self, log: Log) -> None:
        """Log all lines there, and later ones at once."""
        self._log = log
        for level, message in self._lines:
            getattr(log, level)(message)

    def _add(self, level: str, message: str) -> None:
        self._lines.append((level, message))
        if self._log is not None:
            getattr(self._log, level)(message)
