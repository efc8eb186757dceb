# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The interface of what starts processes, and the runner of dry runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol, TYPE_CHECKING

from armsim_ros.launch.api.process import ExecuteLocal
from armsim_ros.launch.process_spec import ProcessSpec
from armsim_ros.launch.report import Report

if TYPE_CHECKING:
    from armsim_ros.launch.engine import Engine

Batch = Sequence[tuple[ExecuteLocal, ProcessSpec]]


class Runner(Protocol):
    """Starts processes and keeps the time."""

    is_dry: bool

    @property
    def is_busy(self) -> bool:
        """Whether anything is running that may still cause events."""

    def open(self, engine: Engine) -> None:
        """Begin; the engine is notified of starts and ends."""

    def start(self, batch: Batch) -> None:
        """Start the processes of a batch."""

    def now(self) -> float:
        """Return the time [s]."""

    async def wait(self, until: float | None) -> None:
        """Wait for an event, at most for a time [s]."""

    def send_signal(self, event: Any) -> None:
        """Send a signal to the processes that an event matches."""

    def stop(self) -> None:
        """Begin to end all processes."""

    async def close(self) -> None:
        """Kill the remaining processes."""


class DryRunner:
    """
    Starts nothing: processes end at once, and time passes only when nothing else is left.

    :param report: takes a line for each process.
    :param is_known: whether a process would be started here.
    """

    is_dry = True
    is_busy = False

    def __init__(self, report: Report, is_known: Callable[[ProcessSpec], bool]) -> None:
        self._report = report
        self._is_known = is_known
        self._now = 0.0
        self._started = 0
        self._engine: Engine | None = None

    def open(self, engine: Engine) -> None:
        """Remember the engine."""
        self._engine = engine

    def start(self, batch: Batch) -> None:
        """Print each process and report its end."""
        assert self._engine is not None
        for action, spec in batch:
            self._started += 1
            name = f'{spec.name}-{self._started}'
            if self._is_known(spec):
                self._report.process(spec)
                self._engine.process_started(action, name, 0, spec)
                self._engine.process_ended(action, name, 0, spec, 0)
            else:
                self._report.not_installed(spec)
                self._engine.process_ended(action, name, 0, spec, 0, was_run=False)

    def now(self) -> float:
        """Return the time [s]."""
        return self._now

    async def wait(self, until: float | None) -> None:
        """Let the time pass."""
        if until is not None:
            self._now = max(self._now, until)

    def send_signal(self, event: Any) -> None:
        """Do nothing: nothing runs."""

    def stop(self) -> None:
        """Do nothing: nothing runs."""

    async def close(self) -> None:
        """Do nothing: nothing runs."""
