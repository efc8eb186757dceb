# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A tree of joint states with a look-up of the nearest one, and samples for it to grow to."""

from __future__ import annotations

from collections.abc import Callable
import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector

SAMPLES = 256
"""Samples that are drawn at once: most of them are often too far from the tree."""


class SearchTree:
    """
    States with the number of the state that each came from.

    :param roots: (k, m) states that came from none.
    """

    def __init__(self, roots: Matrix) -> None:
        self._parents: list[int] = [-1] * len(roots)
        self._table = roots.copy()
        #: (>= k,) samples farther from a state than this are not for it.
        self.radii: Vector = np.full(len(roots), math.inf)
        self._filled = len(roots)

    def __len__(self) -> int:
        """Return the number of states."""
        return self._filled

    def __getitem__(self, number: int) -> Vector:
        """Return a state (m,)."""
        state: Vector = self._table[number]
        return state

    def since(self, number: int) -> Matrix:
        """Return the states (k, m) from a number on; they are not to be changed."""
        return self._table[number:self._filled]

    def nearest(self, values: Vector) -> tuple[int, float]:
        """Return the number of the state nearest to a given one (m,), and their distance."""
        away = self._table[: self._filled] - values
        squares = np.einsum('ij,ij->i', away, away)
        number = int(squares.argmin())
        return number, math.sqrt(float(squares[number]))

    def add(self, parent: int, values: Vector) -> int:
        """Append a state (m,) and return its number."""
        if self._filled == len(self._table):
            grown = np.empty((2 * self._filled + 64, self._table.shape[1]))
            grown[: self._filled] = self._table
            self._table = grown
            self.radii = np.append(self.radii, np.full(len(grown) - self._filled, math.inf))
        self._table[self._filled] = values
        self._filled += 1
        self._parents.append(parent)
        return self._filled - 1

    def add_branch(self, parent: int, states: Matrix) -> int:
        """Append states (k, m), each from the one before; return the number of the last one."""
        for values in states:
            parent = self.add(parent, values)
        return parent

    def branch(self, number: int) -> Matrix:
        """Return the states (k, m) from a number up to its root."""
        found = []
        while number >= 0:
            found.append(self._table[number])
            number = self._parents[number]
        return np.array(found)


class SamplePool:
    """
    Draws many samples at once and follows the tree as it grows.

    :param tree: whose states the samples are for.
    :param draw: returns so many samples (k, m).
    """

    def __init__(self, tree: SearchTree, draw: Callable[[int], Matrix]) -> None:
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
