# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether the simulation is playing, and in which world."""

from __future__ import annotations

from simulation_interfaces.msg import SimulationState

from armsim_ros.sim.clock import SimClock


class RunState:
    """
    The state of the simulation in the words of simulation_interfaces.

    :param clock: knows whether time passes.
    :param world: name of the world that is loaded.
    :param uri: where it can be loaded from.
    """

    def __init__(self, clock: SimClock, world: str, uri: str) -> None:
        self.world: str | None = world
        self.uri = uri
        self.loading = False
        self._clock = clock
        self._stopped_at: int | None = None

    @property
    def now(self) -> int:
        """A constant of ``simulation_interfaces/msg/SimulationState``."""
        if self.loading:
            return int(SimulationState.STATE_LOADING_WORLD)
        if self.world is None:
            return int(SimulationState.STATE_NO_WORLD)
        if not self._clock.paused:
            return int(SimulationState.STATE_PLAYING)
        if self._stopped_at == self._clock.steps:
            return int(SimulationState.STATE_STOPPED)
        return int(SimulationState.STATE_PAUSED)

    def stop(self) -> None:
        """Record that everything is at its start; a step ends that. Pauses the clock."""
        self._clock.paused = True
        self._stopped_at = self._clock.steps

    def pause(self) -> None:
        """Pause time."""
        self._clock.paused = True
        self._stopped_at = None

    def play(self) -> None:
        """Resume time."""
        self._stopped_at = None
        self._clock.paused = False
