# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Pairs of shapes that may touch during motions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from armsim_ros.arrays import Mask, Matrix


class Exactly(Enum):
    """
    When shapes themselves are checked, which takes many times as long as their hulls.

    Hulls that are near are as good as the shapes, unless they touch where the shapes do not.
    """

    NEVER = 'never'
    WHERE_HULLS_TOUCH = 'where hulls touch'
    ALWAYS = 'always'


@dataclass(frozen=True, slots=True, eq=False)
class NearPairs:
    """
    What may touch during k motions, each of which has a state in its middle.

    Shorter motions within these cannot bring together other pairs than these.

    :param weights: (k, joints, n) of ``DisplacementBounds.weights_near``.
    :param pairs: for each collision table (k, pairs).
    :param always: whether shapes touch that no joint moves apart.
    """

    weights: Matrix
    pairs: Sequence[Mask]
    always: bool = False

    @property
    def motions(self) -> Mask:
        """Return in which motions (k,) anything may touch."""
        found = np.full(len(self.weights), self.always)
        for pairs in self.pairs:
            found |= pairs.any(axis=1)
        return found

    def of(self, which: Mask) -> NearPairs:
        """Return the same for some of the motions (k,)."""
        return NearPairs(
            self.weights[which], [pairs[which] for pairs in self.pairs], self.always)

    def halves(self) -> NearPairs:
        """Return the same for both halves of every motion, one after the other."""
        return NearPairs(
            np.repeat(self.weights, 2, axis=0),
            [np.repeat(pairs, 2, axis=0) for pairs in self.pairs], self.always)
