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

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.planning.search.search_tree import SamplePool, SearchTree

#: Radius of the ball after the first failure, and the least one, in extensions.
FIRST_RADIUS, LEAST_RADIUS = 8.0, 4.0
#: By which the radius shrinks with a failure and grows with a success.
RADIUS_CHANGE = 0.1
_SAME = 1e-9


class RRTConnect:
    """
    A search for one path.

    :param low: (m,) where samples come from [rad or m].
    :param high: (m,).
    :param steer: (state, target, distance between them, longest way) -> the states (k, m) on a
        free way to the target, which is the last of them where it is not too far.
    :param extension: the longest way at once [rad or m].
    :param rng: source of chance.
    """

    def __init__(
        self, low: Vector, high: Vector,
        steer: Callable[[Vector, Vector, float, float], Matrix], extension: float,
        rng: np.random.Generator,
    ) -> None:
        self._low, self._span = low, high - low
        self._steer = steer
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
            growing = 0 if len(trees[0]) <= len(trees[1]) else 1
            tree, other = trees[growing], trees[1 - growing]
            grown = self._extend(tree, pools[growing])
            if grown is None:
                continue
            met = self._connect(other, tree[grown], stop)
            if met is None:
                continue
            first, second = tree.branch(grown), other.branch(met)
            if growing:
                first, second = second, first
            return np.concatenate([first[::-1], second[1:]])
        return None

    def _draw(self, count: int) -> Matrix:
        samples: Matrix = self._low + self._span * self._rng.random((count, len(self._low)))
        return samples

    def _extend(self, tree: SearchTree, pool: SamplePool) -> int | None:
        """Grow a tree towards a sample once; return the last new state's number."""
        found = pool.take()
        if found is None:
            return None
        sample, near, distance = found
        self.motions += 1
        last = tree.add_branch(
            near, self._steer(tree[near], sample, distance, self._extension))
        if last != near:
            tree.radii[near] *= 1.0 + RADIUS_CHANGE
            return last
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
        while distance > _SAME:
            if stop():
                return None
            self.motions += 1
            last = tree.add_branch(
                number, self._steer(tree[number], target, distance, self._extension))
            if last == number:
                return None
            number = last
            distance = float(np.linalg.norm(target - tree[number]))
        return number
