# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Random pushes on the tip of an arm, against which a policy becomes robust."""

from __future__ import annotations

from collections.abc import Mapping
import math
from typing import ClassVar

from armsim_ros.env.ranges import Episode, Quantity, stream
from armsim_ros.sim.simulation import Simulation

FORCE, INTERVAL = 'pushes.force', 'pushes.interval'
#: Time from push to push where none is given [s].
_INTERVAL = 1.0


class Pushes:
    """
    Pushes a link, for a step at a time, in random directions.

    :param link: that is pushed at its centre of mass.
    :param period: time of a step [s].
    """

    #: What can be drawn: the force of all pushes of an episode [N], and the time between two [s].
    KNOWN: ClassVar[Mapping[str, Quantity]] = {
        FORCE: Quantity(low=0.0), INTERVAL: Quantity(low=0.0, above=True)}

    def __init__(self, link: str, period: float) -> None:
        self._link, self._period = link, period
        self.begin(Episode({}, 0))

    def begin(self, episode: Episode) -> None:
        """Begin an episode; nothing acts yet."""
        self._force = episode.get(FORCE, 0.0)
        interval = episode.get(INTERVAL, _INTERVAL)
        self._steps = max(1, round(interval / self._period))
        self.random = stream(episode.seed, 'pushes')

    def act(self, simulation: Simulation, step: int) -> None:
        """
        Have act what belongs to a step.

        :param step: number of the step in its episode, from 0.
        """
        if not self._force:
            return
        due, ended = (step + 1) % self._steps == 0, step and step % self._steps == 0
        if due:
            x, y, z = self.random.normal(size=3).tolist()
            factor = self._force / math.sqrt(x * x + y * y + z * z)
            simulation.apply_wrench(self._link, (factor * x, factor * y, factor * z))
        elif ended:
            simulation.apply_wrench(self._link)
