# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A tree of joint states with a look-up of the nearest one."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


class SearchTree:
    """
    States with the number of the state that each came from.

    :param roots: (k, m) states that came from none.
    """

    def __init__(self, roots: Matrix) -> None:
        """Begin with the roots."""
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

    def branch(self, number: int) -> Matrix:
        """Return the states (k, m) from a number up to its root."""
        found = []
        while number >= 0:
            found.append(self._table[number])
            number = self._parents[number]
        return np.array(found)
