# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The time of the simulated world."""

from __future__ import annotations

from collections.abc import Callable

from armsim_ros.config.simulation import checked_factor
from armsim_ros.errors import ControllerError


class SimClock:
    """
    Simulated time: where it started plus the physics steps done since.

    In real time it starts at the wall clock's time, so that stamps of programs with and without
    ``use_sim_time`` agree; in deterministic runs it starts at 0.

    :param step_ns: time of a physics step [ns].
    :param start_ns: time at the start [ns].
    :param paused: whether the world is paused.
    :param real_time_factor: simulated time per wall time; 0 is as fast as it goes.

    ``on_change`` is called, in the thread that does it, when the pace or the pause change.
    """

    def __init__(
        self, step_ns: int, start_ns: int = 0, *, paused: bool = False,
        real_time_factor: float = 1.0
    ) -> None:
        if step_ns <= 0:
            raise ValueError(f'step_ns must be positive, not {step_ns}')
        self.step_ns, self.start_ns = step_ns, start_ns
        self.on_change: Callable[[], object] = lambda: None
        self.paused = paused
        self.steps = 0
        self.real_time_factor = real_time_factor

    @property
    def now_ns(self) -> int:
        """Simulated time [ns]."""
        return self.start_ns + self.steps * self.step_ns

    @property
    def paused(self) -> bool:
        """Whether the world is paused."""
        return self._paused

    @paused.setter
    def paused(self, paused: bool) -> None:
        self._paused = paused
        self.on_change()

    @property
    def real_time_factor(self) -> float:
        """Simulated time per wall time that is requested; 0 is as fast as it goes."""
        return self._real_time_factor

    @real_time_factor.setter
    def real_time_factor(self, factor: float) -> None:
        self._real_time_factor = checked_factor(factor)
        self.on_change()

    @property
    def wall_step_ns(self) -> float:
        """Wall time that a physics step shall take [ns]; 0 where it shall not be waited."""
        return self.step_ns / self._real_time_factor if self._real_time_factor else 0.0

    def advance(self, steps: int = 1) -> None:
        """Move on by some physics steps."""
        self.steps += steps

    def reset(self, start_ns: int = 0) -> None:
        """Go to another time [ns]; pause and factor stay as they are."""
        self.start_ns = start_ns
        self.steps = 0

    def behind_ns(self, wall_ns: int) -> int:
        """Return by how much simulated time is behind a wall clock's time [ns]."""
        return wall_ns - self.now_ns


def steps_per_update(step_ns: int, update_rate: float) -> int:
    """
    Return how many physics steps a control period holds.

    :param step_ns: time of a physics step [ns].
    :param update_rate: rate of the controllers [Hz].
    :raises ControllerError: the period does not hold a whole number of steps.
    """
    steps = round(1e9 / (update_rate * step_ns))
    if steps < 1 or abs(steps * step_ns * update_rate * 1e-9 - 1.0) > 1e-6:
        highest = 1e9 / step_ns
        fitting = ', '.join(f'{highest / n:g}' for n in (1, 2, 4, 5, 10))
        raise ControllerError(
            f'an update rate of {update_rate:g} Hz does not fit a timestep of '
            f'{step_ns * 1e-9:g} s; allowed: {highest:g} Hz by a whole number, such as {fitting}')
    return steps
