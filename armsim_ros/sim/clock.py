# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The time of the simulated world."""

from __future__ import annotations


class SimClock:
    """
    Simulated time: where it started plus the physics steps done since.

    In real time it starts at the wall clock's time, so that stamps of programs with and without
    ``use_sim_time`` agree; in deterministic runs it starts at 0.

    :param step_ns: time of one physics step [ns].
    :param start_ns: time at the start [ns].
    :param paused: whether the world stands still.
    :param real_time_factor: simulated time per wall time.
    """

    def __init__(
        self,
        step_ns: int,
        start_ns: int = 0,
        *,
        paused: bool = False,
        real_time_factor: float = 1.0,
    ) -> None:
        """Start the clock."""
        if step_ns <= 0:
            raise ValueError(f'step_ns must be positive, not {step_ns}')
        self.step_ns = step_ns
        self.start_ns = start_ns
        self.paused = paused
        self.steps = 0
        self.real_time_factor = real_time_factor

    @property
    def now_ns(self) -> int:
        """Simulated time [ns]."""
        return self.start_ns + self.steps * self.step_ns

    @property
    def real_time_factor(self) -> float:
        """Simulated time per wall time that is wanted."""
        return self._real_time_factor

    @real_time_factor.setter
    def real_time_factor(self, factor: float) -> None:
        if not 0.0 < factor <= 100.0:
            raise ValueError(f'the real time factor must be above 0 and up to 100, not {factor}')
        self._real_time_factor = factor

    @property
    def wall_step_ns(self) -> float:
        """Wall time that one physics step shall take [ns]."""
        return self.step_ns / self._real_time_factor

    def advance(self) -> None:
        """Move on by one physics step."""
        self.steps += 1

    def reset(self, start_ns: int = 0) -> None:
        """Go to another time [ns]; pause and factor stay as they are."""
        self.start_ns = start_ns
        self.steps = 0

    def behind_ns(self, wall_ns: int) -> int:
        """Return by how much simulated time is behind a wall clock's time [ns]."""
        return wall_ns - self.now_ns
