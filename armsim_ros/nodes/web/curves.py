# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Trajectories as curves: sampled, thinned out, compared with limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: More points than this are not sent to a panel.
MOST_POINTS = 400


@dataclass(frozen=True, eq=False)
class Curves:
    """
    A trajectory of several joints.

    :param joints: n names.
    :param times: (t,) [s], rising.
    :param positions: (t, n) [rad or m].
    :param velocities: (t, n) [rad/s or m/s].
    :param accelerations: (t, n) [rad/s^2 or m/s^2].
    """

    joints: tuple[str, ...]
    times: Array
    positions: Array
    velocities: Array
    accelerations: Array

    @property
    def duration(self) -> float:
        """The time of the last point [s]."""
        return float(self.times[-1]) if len(self.times) else 0.0

    def at(self, time: float) -> dict[str, float]:
        """Return the joint positions at a time [s], on cubic pieces; held beyond the ends."""
        times = self.times
        if len(times) == 1 or time <= times[0]:
            values = self.positions[0]
        elif time >= times[-1]:
            values = self.positions[-1]
        else:
            index = int(np.searchsorted(times, time, side='right')) - 1
            values = _cubic(time, times[index:index + 2], self.positions[index:index + 2],
                            self.velocities[index:index + 2])
        return dict(zip(self.joints, map(float, values), strict=True))

    def form(self) -> dict[str, Any]:
        """Return lists for a panel, with no more points than can be seen."""
        index = thinned(len(self.times), MOST_POINTS)
        return {
            'joints': list(self.joints),
            'times': _listed(self.times[index]),
            'position': _listed(self.positions[index].T),
            'velocity': _listed(self.velocities[index].T),
            'acceleration': _listed(self.accelerations[index].T),
        }


def curves_of(joints: Sequence[str], times: Sequence[float], positions: Sequence[Sequence[float]],
              velocities: Sequence[Sequence[float]] = (),
              accelerations: Sequence[Sequence[float]] = ()) -> Curves:
    """
    Return the curves of a trajectory's points; derivatives that are not given are computed.

    :raises ValueError: the points do not fit the joints, or a number is not finite.
    """
    t = np.asarray(times, np.float64)
    q = np.asarray(positions, np.float64).reshape(len(t), -1)
    if not len(t) or q.shape[1] != len(joints):
        raise ValueError(f'{q.shape[1]} positions a point for {len(joints)} joints')
    if not (np.isfinite(t).all() and np.isfinite(q).all()):
        raise ValueError('a number is not finite')
    v = _given(velocities, q.shape)
    a = _given(accelerations, q.shape)
    v = _slope(t, q) if v is None else v
    a = _slope(t, v) if a is None else a
    return Curves(tuple(joints), t, q, v, a)


@dataclass
class Trace:
    """
    What controllers reported while a motion went on.

    :param rows: joint -> (time [s], desired, actual, error) rows [rad or m].
    """

    rows: dict[str, list[tuple[float, float, float, float]]] = field(default_factory=dict)

    def add(self, time: float, joints: Sequence[str], desired: Sequence[float],
            actual: Sequence[float], error: Sequence[float]) -> None:
        """Record a report; a report without a value for each joint is left out."""
        if min(len(desired), len(actual), len(error)) < len(joints):
            return
        for name, *values in zip(joints, desired, actual, error, strict=False):
            row = (time, float(values[0]), float(values[1]), float(values[2]))
            self.rows.setdefault(name, []).append(row)

    def form(self) -> dict[str, Any]:
        """Return lists for a panel, times from the first report on."""
        found: dict[str, Any] = {}
        starts = [rows[0][0] for rows in self.rows.values() if rows]
        start = min(starts, default=0.0)
        for name, rows in self.rows.items():
            table = np.array(rows)[thinned(len(rows), MOST_POINTS)]
            found[name] = {
                'times': _listed(table[:, 0] - start), 'desired': _listed(table[:, 1]),
                'actual': _listed(table[:, 2]), 'error': _listed(table[:, 3]),
            }
        return found


def thinned(count: int, most: int) -> NDArray[np.int64]:
    """Return the indices of at most so many points, the first and the last among them."""
    if count <= most:
        return np.arange(count)
    return np.unique(np.linspace(0, count - 1, most).round().astype(np.int64))


def _given(rows: Sequence[Sequence[float]], shape: tuple[int, ...]) -> Array | None:
    table = [row for row in rows if len(row) == shape[1]]
    return np.asarray(table, np.float64) if len(table) == shape[0] else None


def _slope(times: Array, values: Array) -> Array:
    if len(times) < 2 or (np.diff(times) <= 0.0).any():
        return np.zeros_like(values)
    return np.asarray(np.gradient(values, times, axis=0))


def _cubic(time: float, times: Array, q: Array, v: Array) -> Array:
    """Return the cubic with the positions and velocities of two points, at a time."""
    step = float(times[1] - times[0])
    s = (time - float(times[0])) / step
    return np.asarray(
        (2 * s**3 - 3 * s**2 + 1) * q[0] + (s**3 - 2 * s**2 + s) * step * v[0]
        + (3 * s**2 - 2 * s**3) * q[1] + (s**3 - s**2) * step * v[1])


def _listed(values: Array) -> Any:
    return np.round(values, 6).tolist()
