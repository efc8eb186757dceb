# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Shorter paths: shortcuts between points of a path, waypoints left out, corners cut."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import accumulate

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.planning.search.joint_space import JointSpace

DRAWS = 16
"""Pairs of points of which the pair with most to gain is tried, after a success."""

BATCH = 8
"""Shortcuts whose pairs are drawn at once."""

LEAST_GAIN = 0.01
"""Share of the path's length that a shortcut has to save."""

FAILURES = 4
"""Shortcuts in a row without success after which a straight path is left as it is."""

PATIENCE = 2.0
"""How many times more failures a path is worth that is twice as long as the straight line."""

MOST_PATIENCE = 5.0
"""How many times more failures are accepted at most."""

CUTS = np.array([0.8, 0.4, 0.2, 0.1])
"""How far from a corner it is cut, as shares of its longer side: the first that is free."""

MOST_CUTS = 40
"""Cuts that are tried at most."""

_STRAIGHT = 1e-12


def with_shortcuts(
    waypoints: Matrix, space: JointSpace, rng: np.random.Generator,
    stop: Callable[[], bool], failures: int = FAILURES,
) -> Matrix:
    """
    Return a path with shortcuts between any of its points.

    Of several pairs of points drawn by chance the pair that saves most is checked; the more of
    them are blocked, the fewer are drawn, so that small savings get their turn (shortcuts by
    chance alone: Geraerts and Overmars 2007, DOI 10.1177/0278364907079280).

    :param waypoints: (k, m) of a free path.
    :param space: joins states, and checks motions between them.
    :param stop: asked before every shortcut.
    :param failures: shortcuts in vain after which it ends where the path is hardly longer
        than the straight line; the longer it is, the more.
    """
    path = _without_straight(without_repeats(waypoints))
    vain, draws = 0, DRAWS
    apart = max(float(np.linalg.norm(path[-1] - path[0])), 1e-9)
    while len(path) > 2 and not stop():
        pairs = _Pairs(path, draws, rng)
        most = failures * min(1.0 + PATIENCE * (pairs.length / apart - 1.0), MOST_PATIENCE)
        for k in range(BATCH):
            if vain >= most or (k and stop()):
                break
            shorter = pairs.shortcut(k, space)
            if shorter is not None:
                path, vain, draws = shorter, 0, min(2 * draws, DRAWS)
                break
            vain, draws = vain + 1, max(draws // 2, 1)
        if vain >= most:
            break
    return path


def with_corners_cut(path: Matrix, space: JointSpace, stop: Callable[[], bool]) -> Matrix:
    """
    Return a path with no waypoint more than it needs, and its corners cut.

    What shortcuts leave are corners close to obstacles; these are cut one by one, which a pair of
    points drawn by chance seldom does.

    :param path: (k, m) free, neighbours different.
    :param space: checks motions.
    :param stop: asked before every motion.
    """
    path = _reduced(path, space.shortcut_free, stop)
    return without_repeats(_cut(path, space.corner_free, stop))


class _Pairs:
    """
    Pairs of points of a path, drawn for several shortcuts at once; the first is for most pairs.

    :param path: (k, m) waypoints.
    :param draws: pairs for the first shortcut; for each further one it is half as many.
    """

    def __init__(self, path: Matrix, draws: int, rng: np.random.Generator) -> None:
        self._path = path
        segments = path[1:] - path[:-1]
        lengths = _norms(segments)
        covered: Vector = np.zeros(len(path))
        lengths.cumsum(out=covered[1:])
        self.length = float(covered[-1])
        counts = [max(draws >> k, 1) for k in range(BATCH)]
        self._ends = list(accumulate(counts, initial=0))
        places = self.length * rng.random((self._ends[-1], 2))
        places.sort(axis=1)
        self._pieces = pieces = covered[1:-1].searchsorted(places, side='right')
        self._points = path[pieces] + ((places - covered[pieces]) / lengths[pieces])[
            ..., None] * segments[pieces]
        self._ways = places[:, 1] - places[:, 0]
        self._gains = self._ways - _norms(self._points[:, 1] - self._points[:, 0])

    def shortcut(self, number: int, space: JointSpace) -> Matrix | None:
        """Return the path with the shortcut of that number; None where it gains too little."""
        begin, end = self._ends[number:number + 2]
        best = begin + int(self._gains[begin:end].argmax())
        least = LEAST_GAIN * self.length
        if self._gains[best] <= least:
            return None
        first, second = self._points[best]
        between = space.join(first, second)
        if between is None:
            return None
        shortcut = np.concatenate([first[None], between, second[None]])
        if len(between) and self._ways[best] - path_length(shortcut) <= least:
            return None
        before, after = self._pieces[best]
        return without_repeats(np.concatenate(
            [self._path[:before + 1], shortcut, self._path[after + 1:]]))


def _reduced(
    path: Matrix, motion_free: Callable[[Vector, Vector], bool], stop: Callable[[], bool]
) -> Matrix:
    """Leave out the waypoints whose neighbours can be joined, those that turn least first."""
    open_ = np.ones(len(path), dtype=bool)
    while len(path) > 2 and not stop():
        lengths = _norms(path[1:] - path[:-1])
        detours = lengths[:-1] + lengths[1:] - _norms(path[2:] - path[:-2])
        corner = 1 + int(np.where(open_[1:-1], detours, np.inf).argmin())
        if not open_[corner]:
            break
        open_[corner] = False
        if motion_free(path[corner - 1], path[corner + 1]):
            open_[[corner - 1, corner + 1]] = True
            path, open_ = np.delete(path, corner, axis=0), np.delete(open_, corner)
    return path


def _cut(
    path: Matrix, motion_free: Callable[[Vector, Vector], bool], stop: Callable[[], bool]
) -> Matrix:
    """Cut corners as far as that is free, those first that save most."""
    tried = np.zeros(len(path), dtype=np.intp)
    for _ in range(MOST_CUTS):
        if len(path) < 3 or stop():
            break
        segments = path[1:] - path[:-1]
        lengths = _norms(segments)
        reach = CUTS[np.minimum(tried[1:-1], len(CUTS) - 1)] * np.maximum(
            lengths[:-1], lengths[1:])
        before, after = np.minimum(reach, lengths[:-1]), np.minimum(reach, lengths[1:])
        first = path[1:-1] - segments[:-1] * (before / lengths[:-1])[:, None]
        second = path[1:-1] + segments[1:] * (after / lengths[1:])[:, None]
        gains = before + after - _norms(second - first)
        gains[tried[1:-1] >= len(CUTS)] = 0.0
        best = int(gains.argmax())
        if gains[best] <= LEAST_GAIN * float(lengths.sum()):
            break
        corner = best + 1
        if not motion_free(first[best], second[best]):
            tried[corner] += 1
            continue
        kept = [point for point, whole in (
            (first[best], before[best] >= lengths[best]),
            (second[best], after[best] >= lengths[corner])) if not whole]
        if before[best] >= lengths[best]:
            tried[corner - 1] = 0
        if after[best] >= lengths[corner]:
            tried[corner + 1] = 0
        path = np.concatenate([path[:corner], np.array(kept).reshape(len(kept), -1),
                               path[corner + 1:]])
        tried = np.concatenate([tried[:corner], np.ones(len(kept), dtype=np.intp),
                                tried[corner + 1:]])
    return path


def _without_straight(path: Matrix) -> Matrix:
    """Return a path (k, m) without the waypoints at which it goes on straight."""
    steps = path[1:] - path[:-1]
    lengths = _norms(steps)
    detours = lengths[:-1] + lengths[1:] - _norms(path[2:] - path[:-2])
    bent = np.ones(len(path), dtype=bool)
    bent[1:-1] = detours > _STRAIGHT * lengths[1:]
    return path[bent]


def _norms(rows: Matrix) -> Vector:
    norms: Vector = np.sqrt(np.einsum('ij,ij->i', rows, rows))
    return norms


def without_repeats(waypoints: Sequence[Vector] | Matrix, distance: float = 1e-7) -> Matrix:
    """Return waypoints (k, m) without those that equal their predecessor; both ends stay."""
    rows = np.asarray(waypoints)
    if len(rows) < 2 or float(_norms(rows[1:] - rows[:-1]).min()) > distance:
        return rows
    kept = [waypoints[0]]
    for point in waypoints[1:]:
        if float(np.linalg.norm(point - kept[-1])) > distance:
            kept.append(point)
    if len(kept) > 1:
        kept[-1] = waypoints[-1]
    return np.array(kept)


def path_length(waypoints: Vector) -> float:
    """Return the length of a polyline (k, m) in joint space [rad or m]."""
    return float(np.sum(np.linalg.norm(np.diff(waypoints, axis=0), axis=1)))
