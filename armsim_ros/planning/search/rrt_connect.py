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
import math

import numpy as np

from armsim_ros.arrays import Mask, Matrix, Vector

SAMPLES = 256
"""Samples that are drawn at once: most of them are often too far from the tree."""

DRAWS = 8
"""Draws at most until one of the samples is where shorter paths pass."""

_SAME = 1e-9


class SearchTree:
    """
    States with the number of the state that each came from.

    :param roots: (k, m) states that came from none.
    """

    def __init__(self, roots: Matrix) -> None:
        self._parents: list[int] = [-1] * len(roots)
        self._table = roots.copy()
        #: Samples farther from a state than this are not for it.
        self.radii = [math.inf] * len(roots)
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
        """Return the number of the state nearest to a given state (m,), and their distance."""
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
        self._table[self._filled] = values
        self._filled += 1
        self._parents.append(parent)
        self.radii.append(math.inf)
        return self._filled - 1

    def add_branch(self, parent: int, states: Matrix) -> int:
        """Append states (k, m), each from its predecessor; return the number of the last."""
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
        self._tree, self._draw = tree, draw
        self._samples: Matrix = np.empty((0, 0))
        #: Squares of the distances of samples to their nearest states.
        self._squares: Vector = np.empty(0)
        # Distances and states as lists: read one by one, these are faster.
        self._distances: list[float] = []
        self._nearest: list[int] = []
        self._next = 0
        self._seen = 0
        self._work: Vector = np.empty(0)

    def take(self) -> tuple[Vector, int, float] | None:
        """
        Return the next sample that is within the radius of its nearest state.

        :returns: the sample (m,), the state's number and their distance; None where all that
            were left are outside, and others are drawn at the next call.
        """
        if self._next < len(self._samples):
            self._follow()
        else:
            self._renew()
        radii, nearest, distances = self._tree.radii, self._nearest, self._distances
        for number in range(self._next, len(distances)):
            if distances[number] <= radii[nearest[number]]:
                self._next = number + 1
                return self._samples[number], nearest[number], distances[number]
        self._next = len(distances)
        return None

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
        np.matmul(self._samples, -2.0 * states.T, out=partial)
        partial += np.einsum('ij,ij->i', states, states)
        nearest = partial.argmin(axis=1)
        away = self._samples - states[nearest]
        self._squares = np.einsum('ij,ij->i', away, away)
        self._nearest, self._distances = nearest.tolist(), np.sqrt(self._squares).tolist()
        self._next, self._seen = 0, len(states)

    def _follow(self) -> None:
        """Look whether states that are new are nearer."""
        count = len(self._tree)
        if count == self._seen:
            return
        left, before = self._samples[self._next:], self._squares[self._next:]
        for number, state in enumerate(self._tree.since(self._seen), self._seen):
            away = left - state
            squares = np.einsum('ij,ij->i', away, away)
            closer = squares < before
            for place in closer.nonzero()[0].tolist():
                square = before[place] = squares[place]
                self._distances[self._next + place] = math.sqrt(square)
                self._nearest[self._next + place] = number
        self._seen = count


class ShorterPaths:
    """
    Draws states that paths shorter than a given length can pass.

    They are in ellipsoids about the start and a goal each (Gammell et al. 2014,
    DOI 10.1109/IROS.2014.6942976).

    :param low: (m,) where states are drawn from [rad or m].
    :param high: (m,).
    :param start: (m,).
    :param goals: (k, m), k >= 1, all nearer to the start than ``length``.
    :param length: of the paths, at most [rad or m].
    :param rng: source of chance.
    """

    def __init__(
        self, low: Vector, high: Vector, start: Vector, goals: Matrix, length: float,
        rng: np.random.Generator,
    ) -> None:
        self._low, self._high, self._rng = low, high, rng
        self._start, self._goals, self._length = start, goals, length
        ways = goals - start
        apart = np.linalg.norm(ways, axis=1)
        self._centres = start + 0.5 * ways
        #: Half axes (k, m) of the ellipsoids, the first from start to goal.
        self._halves = np.repeat(0.5 * np.sqrt(length**2 - apart**2), len(start)).reshape(
            ways.shape)
        self._halves[:, 0] = 0.5 * length
        # What a reflection at the plane with this normal takes to the first axis is the way.
        normals = ways / np.maximum(apart, _SAME)[:, None]
        normals[:, 0] -= 1.0
        self._normals = normals / np.maximum(np.linalg.norm(normals, axis=1), _SAME)[:, None]
        half = 0.5 * len(start)
        ball = half * math.log(math.pi) - math.lgamma(half + 1.0)
        volumes = np.log(self._halves).sum(axis=1) + ball
        self._fills = float(volumes.max()) > float(np.log(high - low).sum())

    def draw(self, count: int) -> Matrix:
        """
        Return so many of the states at most (k, m), at least one.

        What is drawn is the smaller of ellipsoids and bounds; what is outside the other is left
        out. States anywhere within bounds are returned where nothing is inside both.
        """
        for _ in range(DRAWS):
            states = self._bounded(count) if self._fills else self._in_ellipsoids(count)
            inside = states[self._shorter(states) if self._fills else (
                (states >= self._low) & (states <= self._high)).all(axis=1)]
            if len(inside):
                return inside
        return self._bounded(count)

    def _bounded(self, count: int) -> Matrix:
        return self._rng.uniform(self._low, self._high, (count, len(self._low)))

    def _in_ellipsoids(self, count: int) -> Matrix:
        goal = self._rng.integers(len(self._goals), size=count)
        points = self._rng.standard_normal((count, len(self._low)))
        radii = self._rng.random(count) ** (1.0 / len(self._low))
        points *= (radii / np.linalg.norm(points, axis=1))[:, None]
        points *= self._halves[goal]
        normals = self._normals[goal]
        points -= 2.0 * np.einsum('ij,ij->i', points, normals)[:, None] * normals
        return points + self._centres[goal]

    def _shorter(self, states: Matrix) -> Mask:
        lengths = np.linalg.norm(states - self._start, axis=1) + np.linalg.norm(
            states[:, None] - self._goals, axis=2).min(axis=1)
        shorter: Mask = lengths < self._length
        return shorter


#: Radius of the ball after the first failure, and the least radius, in extensions.
FIRST_RADIUS, LEAST_RADIUS = 8.0, 4.0
#: By which the radius shrinks with a failure and grows with a success.
RADIUS_CHANGE = 0.1


class RRTConnect:
    """
    A search for a path.

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
        self._steer, self._extension, self._rng = steer, extension, rng
        self.motions = 0

    def find(
        self, start: Vector, goals: Sequence[Vector], stop: Callable[[], bool],
        shorter_than: float = math.inf,
    ) -> Matrix | None:
        """
        Return the states (k, m) of a path to any of the goals; None where it was stopped.

        :param start: (m,) a free state.
        :param goals: (m,) free states.
        :param stop: asked before every extension.
        :param shorter_than: samples are drawn where paths pass that are shorter [rad or m].
        """
        trees = (SearchTree(start[None]), SearchTree(np.array(goals)))
        draw = self._draw
        near = [goal for goal in goals if np.linalg.norm(goal - start) < shorter_than]
        if near and shorter_than < math.inf:
            draw = ShorterPaths(
                self._low, self._low + self._span, start, np.array(near), shorter_than,
                self._rng).draw
        pools = [SamplePool(tree, draw) for tree in trees]
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
        smaller = tree.radii[near] * (1.0 - RADIUS_CHANGE)
        tree.radii[near] = min(
            FIRST_RADIUS * self._extension, max(LEAST_RADIUS * self._extension, smaller))
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
