# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Samples for a growing tree, each with the state that is nearest to it."""

from __future__ import annotations

from collections.abc import Callable
import math

import numpy as np
from numpy.typing import NDArray

from armsim_ros.planning.search_tree import SearchTree

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

SAMPLES = 256
"""Samples that are drawn at once: most of them are often too far from the tree."""


class SamplePool:
    """
    Draws many samples at once and follows the tree as it grows.

    :param tree: whose states the samples are for.
    :param draw: returns so many samples (k, m).
    """

    def __init__(self, tree: SearchTree, draw: Callable[[int], Matrix]) -> None:
        """Begin without samples."""
        self._tree = tree
        self._draw = draw
        self._samples: Matrix = np.empty((0, 0))
        self._squares: Vector = np.empty(0)
        self._nearest = np.empty(0, dtype=np.intp)
        self._seen = 0
        self._work: Vector = np.empty(0)

    def take(self) -> tuple[Vector, int, float] | None:
        """
        Return the next sample that is within the radius of its nearest state.

        :returns: the sample (m,), the state's number and their distance; None where all that
            were left are outside, and others are drawn at the next call.
        """
        if len(self._samples):
            self._follow()
        else:
            self._renew()
        radii = self._tree.radii[self._nearest]
        within = self._squares <= radii * radii
        first = int(within.argmax())
        if not within[first]:
            self._samples = self._samples[:0]
            return None
        found = (
            self._samples[first], int(self._nearest[first]), math.sqrt(self._squares[first]))
        rest = slice(first + 1, None)
        self._samples, self._squares = self._samples[rest], self._squares[rest]
        self._nearest = self._nearest[rest]
        return found

    def _renew(self) -> None:
        """Draw, and find the nearest of all states for each sample."""
        self._samples = self._draw(SAMPLES)
        states = self._tree.since(0)
        shape = len(self._samples), len(states)
        count = shape[0] * shape[1]
        if count > len(self._work):
            self._work = np.empty(2 * count)
        # |a - b|^2 without the part that is the same for all states; in memory that stays, since
        # the system takes its time to give so much.
        partial = self._work[:count].reshape(shape)
        np.matmul(self._samples, states.T, out=partial)
        partial *= -2.0
        partial += np.einsum('ij,ij->i', states, states)
        self._nearest = partial.argmin(axis=1)
        away = self._samples - states[self._nearest]
        self._squares = np.einsum('ij,ij->i', away, away)
        self._seen = len(states)

    def _follow(self) -> None:
        """Look whether states that are new are nearer."""
        count = len(self._tree)
        if count == self._seen:
            return
        for number, state in enumerate(self._tree.since(self._seen), self._seen):
            away = self._samples - state
            squares = np.einsum('ij,ij->i', away, away)
            closer = np.flatnonzero(squares < self._squares)
            self._squares[closer] = squares[closer]
            self._nearest[closer] = number
        self._seen = count
