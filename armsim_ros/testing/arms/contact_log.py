# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which bodies touched, and when."""

from __future__ import annotations

import numpy as np

from armsim_ros.sim.simulation import Simulation
from armsim_ros.testing.arms.arm import Touch

Pair = tuple[str, str]


class ContactLog:
    """
    Samples the contacts of a simulation, and keeps what has begun to touch.

    Pairs that touch when the log is begun are at rest on each other and left out.

    :param simulation: whose contacts are recorded.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._ended: list[Touch] = []
        self._lasting: dict[Pair, tuple[float, float]] = {}
        self._now = 0.0
        self._last = b''
        self._resting = frozenset(self._deepest())

    def look(self, now_ns: int) -> None:
        """Note what touches at a simulated time [ns]."""
        self._now = now_ns * 1e-9
        bodies, depths = self._simulation.touching()
        signature = bodies[depths >= 0.0].tobytes()
        if not signature and not self._lasting:
            self._last = signature
            return
        if signature == self._last and not self._lasting:
            return  # what rests on something goes on resting
        self._last = signature
        deepest = {
            pair: depth for pair, depth in self._deepest().items() if pair not in self._resting
        }
        for pair in [pair for pair in self._lasting if pair not in deepest]:
            self._ended.append(self._touch(pair))
            del self._lasting[pair]
        for pair, depth in deepest.items():
            start, before = self._lasting.get(pair, (self._now, 0.0))
            self._lasting[pair] = (start, max(before, depth))

    def touches(self, since: float | None = None) -> tuple[Touch, ...]:
        """Return all touches that lasted beyond a time [s], oldest first; None: all."""
        seen = [*self._ended, *(self._touch(pair) for pair in self._lasting)]
        requested = (touch for touch in seen if since is None or touch.end >= since)
        return tuple(sorted(requested, key=lambda touch: touch.start))

    def _deepest(self) -> dict[Pair, float]:
        bodies, depths = self._simulation.touching()
        names = self._simulation.body_names
        found: dict[Pair, float] = {}
        for i in np.flatnonzero(depths >= 0.0):
            pair = (names[bodies[i, 0]], names[bodies[i, 1]])
            found[pair] = max(found.get(pair, 0.0), float(depths[i]))
        return found

    def _touch(self, pair: Pair) -> Touch:
        start, depth = self._lasting[pair]
        return Touch(pair, start, self._now, depth)
