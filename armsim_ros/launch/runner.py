# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the event loop needs of whoever starts the processes; the dry run's."""

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
    """Starts processes and knows what time it is."""

    is_dry: bool

    @property
    def is_busy(self) -> bool:
        """Whether anything runs that may still do something."""

    def open(self, engine: Engine) -> None:
        """Begin; tells the engine of starts and ends."""

    def start(self, batch: Batch) -> None:
        """Start processes that stand together."""

    def now(self) -> float:
        """Return the time [s]."""

    async def wait(self, until: float | None) -> None:
        """Wait for something to happen, or for a time [s]."""

    def send_signal(self, event: Any) -> None:
        """Send a signal to the processes that an event means."""

    def stop(self) -> None:
        """Begin to end all processes."""

    async def close(self) -> None:
        """Leave no process behind."""


class DryRunner:
    """
    Starts nothing: processes end at once, and a time has passed when nothing else is to do.

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
        """Remember whom to tell."""
        self._engine = engine

    def start(self, batch: Batch) -> None:
        """Print each process and let it end."""
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
