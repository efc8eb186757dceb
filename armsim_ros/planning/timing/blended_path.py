# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A polyline in joint space with its corners rounded by parabolas."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Vector

MERGE_DISTANCE = 1e-6
"""Waypoints nearer than this [rad or m] are one."""


class BlendedPath:
    """
    Straight segments that a parabola joins at every inner waypoint.

    A blend leaves the incoming segment at a distance d before the corner and meets the outgoing
    one at d behind it: a quadratic Bezier curve with the corner as its control point, known as
    the Hermite blend that keeps the direction at both ends. Path position runs at speed 1 on the
    segments; the first derivative is continuous and, on a blend, linear; the second is constant
    on each piece. So joint velocity and acceleration take their extremes at the ends of a piece.

    :param waypoints: (m, n) m >= 2 different positions [rad or m].
    :param deviation: the largest distance between corner and curve [rad or m]; a number, or one
        for each of the m - 2 inner waypoints.
    """

    def __init__(self, waypoints: Vector, deviation: float | Sequence[float] | Vector) -> None:
        points = np.asarray(waypoints, dtype=np.float64)
        steps = np.diff(points, axis=0)
        lengths = np.linalg.norm(steps, axis=1)
        if len(points) < 2 or not bool(np.all(lengths > 0.0)):
            raise ValueError('a path needs two or more waypoints, neighbours different')
        self.waypoints = points
        self.deviation = np.broadcast_to(np.asarray(deviation, dtype=np.float64),
                                         (len(points) - 2,)).copy()
        directions = steps / lengths[:, None]
        reach = self._blend_reach(directions, lengths)
        starts: list[Vector] = []
        slopes: list[Vector] = []
        curvatures: list[Vector] = []
        spans: list[float] = []
        self.corner_pieces: dict[int, int] = {}
        at = points[0]
        for k in range(len(steps)):
            before = reach[k - 1] if k else 0.0
            after = reach[k] if k < len(reach) else 0.0
            straight = max(lengths[k] - before - after, 0.0)
            if straight > MERGE_DISTANCE or not spans:
                starts.append(at)
                slopes.append(directions[k])
                curvatures.append(np.zeros(points.shape[1]))
                spans.append(straight)
            at = points[k + 1] - after * directions[k]
            if after > 0.0:
                self.corner_pieces[k] = len(spans)
                starts.append(at)
                slopes.append(directions[k])
                curvatures.append((directions[k + 1] - directions[k]) / (2.0 * after))
                spans.append(2.0 * after)
                at = points[k + 1] + after * directions[k + 1]
        self._starts = np.array(starts)
        self._slopes = np.array(slopes)
        self._curvatures = np.array(curvatures)
        self.spans = np.array(spans)
        self.knots = np.concatenate([[0.0], np.cumsum(self.spans)])

    def _blend_reach(self, directions: Vector, lengths: Vector) -> Vector:
        turn = np.linalg.norm(np.diff(directions, axis=0), axis=1)
        wanted = 4.0 * self.deviation / np.maximum(turn, 1e-9)
        limit = 0.5 * np.minimum(lengths[:-1], lengths[1:])
        reach: Vector = np.where(turn < 1e-9, 0.0, np.minimum(wanted, limit))
        return reach

    @property
    def length(self) -> float:
        """Path position of the end [rad or m]."""
        return float(self.knots[-1])

    def piece_at(self, s: Vector) -> NDArray[np.int64]:
        """Return for every path position the piece that holds it, the later one at a knot."""
        found = np.searchsorted(self.knots, s, side='right') - 1
        return np.clip(found, 0, len(self.spans) - 1)

    def position(self, s: Vector) -> Vector:
        """Return the joint positions (k, n) at path positions s (k,)."""
        piece = self.piece_at(s)
        x = (s - self.knots[piece])[:, None]
        result: Vector = self._starts[piece] + x * (
            self._slopes[piece] + 0.5 * x * self._curvatures[piece]
        )
        return result

    def slope(self, s: Vector, piece: NDArray[np.int64] | None = None) -> Vector:
        """
        Return the first derivative (k, n).

        :param s: (k,) path positions.
        :param piece: (k,) which piece's polynomial to use; default the one that holds s.
        """
        which = self.piece_at(s) if piece is None else piece
        x = (s - self.knots[which])[:, None]
        result: Vector = self._slopes[which] + x * self._curvatures[which]
        return result

    def curvature(self, piece: NDArray[np.int64]) -> Vector:
        """Return the second derivative (k, n), which is constant on a piece."""
        result: Vector = self._curvatures[piece]
        return result

    def corner_samples(self, corner: int, count: int) -> Vector:
        """
        Return positions on the blend at an inner waypoint.

        :param corner: 0 for the first inner waypoint.
        :param count: how many, ends included.
        :returns: (count, n); (0, n) where that waypoint has no blend.
        """
        piece = self.corner_pieces.get(corner)
        if piece is None:
            return np.empty((0, self.waypoints.shape[1]))
        return self.position(np.linspace(self.knots[piece], self.knots[piece + 1], count))
