# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
RRT-Connect with adaptive domains.

Two trees grow towards each other (Kuffner and LaValle 2000, DOI 10.1109/ROBOT.2000.844730). A
state whose extensions fail takes samples from a ball around it only, the smaller the more they
fail (Jaillet et al. 2005, DOI 10.1109/IROS.2005.1545607), and the smaller tree grows first: so
little is spent on motions into walls, which is what most of the time goes into otherwise.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from armsim_ros.planning.sample_pool import SamplePool
from armsim_ros.planning.search_tree import SearchTree

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

#: Radius of the ball after the first failure, and the least one, in extensions.
FIRST_RADIUS, LEAST_RADIUS = 8.0, 4.0
#: By which the radius shrinks with a failure and grows with a success.
RADIUS_CHANGE = 0.1


class RRTConnect:
    """
    A search for one path.

    :param low: (m,) where samples come from [rad or m].
    :param high: (m,).
    :param motion_free: whether the straight motion from a free state to another is free.
    :param extension: length of the longest motion [rad or m].
    :param rng: source of chance.
    """

    def __init__(
        self, low: Vector, high: Vector, motion_free: Callable[[Vector, Vector], bool],
        extension: float, rng: np.random.Generator,
    ) -> None:
        """Keep the parts."""
        self._low, self._span = low, high - low
        self._motion_free = motion_free
        self._extension = extension
        self._rng = rng
        self.motions = 0

    def find(
        self, start: Vector, goals: Sequence[Vector], stop: Callable[[], bool]
    ) -> Matrix | None:
        """
        Return the states (k, m) of a path to any of the goals; None where it was stopped.

        :param start: (m,) a free state.
        :param goals: (m,) free states.
        :param stop: asked before every extension.
        """
        trees = (SearchTree(start[None]), SearchTree(np.array(goals)))
        pools = [SamplePool(tree, self._draw) for tree in trees]
        while not stop():
            one = 0 if len(trees[0]) <= len(trees[1]) else 1
            grown = self._extend(trees[one], pools[one])
            if grown is None:
                continue
            met = self._connect(trees[1 - one], trees[one][grown], stop)
            if met is None:
                continue
            first, second = trees[one].branch(grown), trees[1 - one].branch(met)
            if one:
                first, second = second, first
            return np.concatenate([first[::-1], second[1:]])
        return None

    def _draw(self, count: int) -> Matrix:
        samples: Matrix = self._low + self._span * self._rng.random((count, len(self._low)))
        return samples

    def _extend(self, tree: SearchTree, pool: SamplePool) -> int | None:
        """Grow a tree towards a sample by one motion; return the new state's number."""
        found = pool.take()
        if found is None:
            return None
        sample, near, distance = found
        state = tree[near]
        if distance > self._extension:
            sample = state + (sample - state) * (self._extension / distance)
        self.motions += 1
        if self._motion_free(state, sample):
            tree.radii[near] *= 1.0 + RADIUS_CHANGE
            return tree.add(near, sample)
        tree.radii[near] = self._extension * min(
            FIRST_RADIUS,
            max(LEAST_RADIUS, tree.radii[near] / self._extension * (1.0 - RADIUS_CHANGE)),
        )
        return None

    def _connect(
        self, tree: SearchTree, target: Vector, stop: Callable[[], bool]
    ) -> int | None:
        """Grow a tree to a state; return that state's number there, None where it is cut off."""
        number, distance = tree.nearest(target)
        while not stop():
            state = tree[number]
            last = distance <= self._extension
            following = target if last else (
                state + (target - state) * (self._extension / distance))
            self.motions += 1
            if not self._motion_free(state, following):
                return None
            number = tree.add(number, following)
            if last:
                return number
            distance -= self._extension
        return None
