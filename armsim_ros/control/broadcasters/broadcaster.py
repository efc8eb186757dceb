# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The base of controllers that sample states at a rate of simulated time for others to publish.

The control loop's thread samples; a single thread takes the samples, in order, with ``poll``.
"""

from __future__ import annotations

from abc import abstractmethod
from collections import deque
from collections.abc import Callable
from typing import ClassVar, Generic, TypeVar

from armsim_ros.control.controller import Controller, NEVER_NS, ParametersT
from armsim_ros.control.rate import Rate

SampleT = TypeVar('SampleT')

CAPACITY = 256
"""So many samples wait for their reader; then the oldest are dropped."""


CALM_RATE = 100.0
"""So many samples a second of hardware at rest are enough for calm listeners [Hz]."""


class Broadcaster(Controller[ParametersT], Generic[ParametersT, SampleT]):
    """Commands nothing, and takes a sample whenever a sample is due."""

    only_reads: ClassVar[bool] = True

    def on_init(self) -> None:
        """Begin without samples."""
        self._listener: Callable[[], object] | None = None
        self._samples: deque[SampleT] = deque(maxlen=CAPACITY)
        self._rate = self._calm_rate = Rate(0.0)
        self._calm = False
        self._last_due_ns = -1

    @property
    @abstractmethod
    def publish_rate(self) -> float:
        """Samples a second; infinite is each update, 0 is none [Hz]."""

    @abstractmethod
    def read(self, time_ns: int) -> SampleT:
        """Return a sample of now [ns]."""

    def activate(self, time_ns: int) -> None:
        """Begin a new rhythm: that of everything else with this rate."""
        rate = self.publish_rate
        self._rate = Rate(rate, aligned=True)
        self._calm_rate = Rate(min(rate, CALM_RATE), aligned=True)
        self._last_due_ns = -1

    def deactivate(self, time_ns: int) -> None:
        """Sample no more; what was sampled can still be taken."""
        self.time_ns = time_ns

    def update(self, time_ns: int, period: float) -> None:
        """Take a sample if it is due."""
        if self._rate_of_now.due(time_ns) and time_ns != self._last_due_ns:
            self._last_due_ns = time_ns
            self.sample(time_ns)

    def sample(self, time_ns: int) -> None:
        """Take a sample now [ns]; only in the control loop's thread."""
        self.time_ns = time_ns
        self._samples.append(self.read(time_ns))
        if self._listener is not None:
            self._listener()

    @property
    def calm(self) -> bool:
        """Whether hardware at rest is sampled at ``CALM_RATE`` at most; from any thread."""
        return self._calm

    @calm.setter
    def calm(self, calm: bool) -> None:
        if calm is not self._calm:
            self._calm = calm
            self.context.wake()

    @property
    def _rate_of_now(self) -> Rate:
        return self._calm_rate if self._calm and self.context.hardware.resting else self._rate

    def listen(self, listener: Callable[[], object] | None) -> None:
        """
        Have a function called, in the control loop's thread, when there is a sample.

        Without a listener no update is made for a sample; those that are made take it.
        """
        self._listener = listener
        self.context.wake()

    def next_update(self, time_ns: int) -> int:
        """Return when the next sample is due for the listener [ns]."""
        due_ns = self._rate_of_now.next_due_ns(time_ns) if self._listener is not None else None
        return NEVER_NS if due_ns is None else due_ns

    def poll(self) -> SampleT | None:
        """Return the oldest sample that was not taken, or None."""
        try:
            return self._samples.popleft()
        except IndexError:
            return None
