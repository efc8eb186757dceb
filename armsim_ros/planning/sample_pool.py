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

SAMPLES = 64
"""Samples that are drawn at once."""


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

    def take(self) -> tuple[Vector, int, float] | None:
        """
        Return the next sample that is within the radius of its nearest state.

        :returns: the sample (m,), the state's number and their distance; None where all that
            were left are outside, and others are drawn at the next call.
        """
        if not len(self._samples):
            self._samples = self._draw(SAMPLES)
            self._squares = np.full(len(self._samples), math.inf)
            self._nearest = np.zeros(len(self._samples), dtype=np.intp)
            self._seen = 0
        self._follow()
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

    def _follow(self) -> None:
        """Look whether states that are new are nearer."""
        new = self._tree.since(self._seen)
        if not len(new):
            return
        if len(new) == 1:
            away = self._samples - new
            squares = np.einsum('ij,ij->i', away, away)
            nearest = np.full(len(squares), self._seen)
        else:
            # |a - b|^2 without the part that is the same for all states.
            partial = np.einsum('ij,ij->i', new, new) - 2.0 * (self._samples @ new.T)
            nearest = partial.argmin(axis=1)
            away = self._samples - new[nearest]
            squares = np.einsum('ij,ij->i', away, away)
            nearest = nearest + self._seen
        closer = squares < self._squares
        self._squares = np.where(closer, squares, self._squares)
        self._nearest = np.where(closer, nearest, self._nearest)
        self._seen += len(new)
