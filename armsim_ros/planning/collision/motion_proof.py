# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Whether motions are free between the states that are checked, too.

A state from which no joint can move by half a piece's travel and touch anything proves the whole
piece. Pieces that are not proved are halved, down to a millimetre of motion; so states are
checked closely where something is near, and hardly at all where nothing is (the idea of
Schwarzer, Saha and Latombe 2005, DOI 10.1109/TRO.2004.838012, with margins for distances).
"""

from __future__ import annotations

import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.planning.collision.near_pairs import Exactly, NearPairs
from armsim_ros.planning.collision.state_validity import StateValidity

LONGEST_PIECE = 0.1
"""Largest motion [m] of any point within a piece that is tried to be proved."""

HULL_PIECE = 0.024
"""Longer pieces [m] are checked on hulls alone: halving them is faster than exact checks."""

EXACT_PIECE = 0.003
"""Pieces up to this length [m] are checked on exact shapes wherever hulls are near."""

SHORTEST_PIECE = 0.001
"""A piece in which no point moves further [m] counts as proved by a free state in it."""


def first_blocked(
    points: Matrix, validity: StateValidity, step: float, places: Vector | None = None,
    clearance: float = 0.0,
) -> float | None:
    """
    Return where a polyline in joint space is not free, None where it is free throughout.

    :param points: (k, m) joint positions; fewer than two are not a motion.
    :param step: largest motion [m] of any point between two checks of path constraints.
    :param places: (k,) increasing; what to return a place in, default the number of the point.
    :param clearance: [m] that shall be left to everything.
    """
    if len(points) < 2:
        return None
    travel = np.vstack([np.zeros(points.shape[1]),
                        np.cumsum(np.abs(np.diff(points, axis=0)), axis=0)])
    covered = travel @ validity.displacement_weights
    # Points that move nothing have no place of their own.
    covered += np.arange(len(points)) * (1e-12 * max(float(covered[-1]), 1.0))
    length, width = float(covered[-1]), points.shape[1]
    both = np.hstack([points, travel])
    rates = (both[1:] - both[:-1]) / (covered[1:] - covered[:-1])[:, None]

    def at(where: Vector) -> tuple[Matrix, Matrix]:
        """Return positions and travel at some places."""
        part = covered[1:-1].searchsorted(where, side='right')
        values = both[part] + (where - covered[part])[:, None] * rates[part]
        return values[:, :width], values[:, width:]

    def blocked(where: Vector, pairs: NearPairs | None = None) -> float | None:
        for place in where[validity.blocked(at(where)[0], clearance, pairs)]:
            known = np.arange(float(len(points))) if places is None else places
            return float(np.interp(place, covered, known))
        return None

    found = None
    longest = LONGEST_PIECE
    if validity.path_constraints is not None:
        longest = min(longest, step)
    borders = np.linspace(0.0, length, 1 + math.ceil(length / longest))
    if validity.path_constraints is not None:
        found = blocked(borders)
    lows, highs = borders[:-1], borders[1:]
    pairs: NearPairs | None = None
    while found is None and len(lows):
        middles, count = 0.5 * (lows + highs), len(lows)
        states, travelled = at(np.concatenate([middles, lows, highs]))
        states, half = states[:count], travelled[:count]
        reach = np.maximum(half - travelled[count:2 * count], travelled[2 * count:] - half)
        longest = float(np.max(highs - lows))
        # Each half can bring together only what the whole can.
        pairs = validity.near_pairs(states, reach, _exactly(longest), clearance, pairs)
        near = pairs.motions
        lows, middles, highs, pairs = lows[near], middles[near], highs[near], pairs.of(near)
        last = longest <= SHORTEST_PIECE
        # The states on the way first: most collisions are found there.
        if last or HULL_PIECE < longest <= 2.0 * HULL_PIECE:
            found = blocked(middles, pairs)
        if last:
            break
        lows = np.stack([lows, middles], axis=1).ravel()
        highs = np.stack([middles, highs], axis=1).ravel()
        pairs = pairs.halves()
    return found


def _exactly(length: float) -> Exactly:
    """Return how closely pieces of a length [m] are checked."""
    if length > HULL_PIECE:
        return Exactly.NEVER
    return Exactly.WHERE_HULLS_TOUCH if length > EXACT_PIECE else Exactly.ALWAYS
