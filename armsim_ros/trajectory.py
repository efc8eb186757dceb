# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The joint trajectory that planning makes and controllers run.

Plain values with the content of ``trajectory_msgs/msg/JointTrajectory``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.errors import TrajectoryError

QUANTITIES = ('positions', 'velocities', 'accelerations', 'effort')


def _empty() -> Vector:
    return np.empty(0)


@dataclass(frozen=True, slots=True, eq=False)
class TrajectoryPoint:
    """
    Values of n joints at a moment; length 0 where there is no such quantity.

    :param positions: (n,) [rad or m].
    :param velocities: (n,) [rad/s or m/s].
    :param accelerations: (n,) [rad/s^2 or m/s^2].
    :param effort: (n,) [N*m or N].
    """

    positions: Vector = field(default_factory=_empty)
    velocities: Vector = field(default_factory=_empty)
    accelerations: Vector = field(default_factory=_empty)
    effort: Vector = field(default_factory=_empty)


@dataclass(frozen=True, slots=True, eq=False)
class JointTrajectory:
    """
    k waypoints of n named joints, as immutable arrays.

    A waypoint that does not give a quantity has a row of NaN; all other numbers are finite.

    :param joint_names: (n,) order of the columns.
    :param times: (k,) from the trajectory's start [s].
    :param positions: (k, n) [rad or m].
    :param velocities: (k, n) [rad/s or m/s], None where no waypoint gives any.
    :param accelerations: (k, n) [rad/s^2 or m/s^2], None likewise.
    :param effort: (k, n) [N*m or N], None likewise.
    :param stamp_ns: [ns] when the trajectory starts; 0 is "as soon as it arrives".
    :param fault: why the points that it was made of make no such arrays, '' where they do;
        what runs a trajectory refuses a trajectory with a fault.
    :raises TrajectoryError: an array has another shape, or a number that is not finite.
    """

    joint_names: tuple[str, ...]
    times: Vector = field(default_factory=_empty)
    positions: Matrix = field(default_factory=_empty)
    velocities: Matrix | None = None
    accelerations: Matrix | None = None
    effort: Matrix | None = None
    stamp_ns: int = 0
    fault: str = ''

    def __post_init__(self) -> None:
        """Check the arrays and keep copies of them."""
        shape = np.size(self.times), len(self.joint_names)
        for k in np.flatnonzero(~np.isfinite(self._kept('times', shape[:1]))):
            raise TrajectoryError(
                f'the time of point {k} is {self.times[k]}; allowed: finite numbers')
        for what in QUANTITIES:
            if getattr(self, what) is not None:
                values = self._kept(what, shape)
                odd = ~np.isfinite(values) & ~np.isnan(values).all(axis=1, keepdims=True)
                if odd.any():
                    raise TrajectoryError(_not_finite(self.joint_names, what, values, odd))

    def _kept(self, what: str, shape: tuple[int, ...]) -> Matrix:
        """Return the array that takes the place of a given array."""
        values = np.array(getattr(self, what), dtype=np.float64, order='C')
        if not shape[0] and not values.size:
            values = values.reshape(shape)
        if values.shape != shape:
            raise TrajectoryError(
                f'the {what} of the trajectory have the shape {values.shape}; allowed: {shape}, '
                'a row for each time and a column for each joint')
        values.setflags(write=False)
        object.__setattr__(self, what, values)
        return values

    @classmethod
    def of_points(
        cls, joint_names: Sequence[str], times: Sequence[float], points: Sequence[Any],
        stamp_ns: int = 0,
    ) -> JointTrajectory:
        """
        Return the trajectory of points of which some may give quantities that others lack.

        :param points: a point for each time, each with the attributes of :class:`TrajectoryPoint`.
        :returns: with a fault where a point has values for more or fewer joints, or such as are
            not finite.
        """
        names = tuple(joint_names)
        tables: dict[str, Matrix] = {}
        faults = []
        for what in QUANTITIES:
            rows = [getattr(point, what) for point in points]
            if what == 'positions' or any(map(len, rows)):
                tables[what], fault = _table(names, what, rows)
                faults.append(fault)
        return cls(names, np.array(times), **tables, stamp_ns=stamp_ns,
                   fault=next(filter(None, faults), ''))

    def __len__(self) -> int:
        """Return the number of waypoints."""
        return len(self.times)

    @property
    def duration(self) -> float:
        """Time of the last waypoint [s], 0 for a trajectory without any."""
        return float(self.times[-1]) if len(self) else 0.0

    def points(self) -> Iterator[TrajectoryPoint]:
        """Return the waypoints, with nothing in place of a row of NaN."""
        tables = [getattr(self, what) for what in QUANTITIES]
        for k in range(len(self)):
            yield TrajectoryPoint(*(
                _empty() if table is None or np.isnan(table[k]).any() else table[k]
                for table in tables))

    def since(self, k: int) -> JointTrajectory:
        """Return the waypoints from the k-th on, at their times."""
        return self._selected(slice(k, None), self.joint_names)

    def of_joints(self, joint_names: Sequence[str]) -> JointTrajectory:
        """Return the columns of some of its joints, in the order of these names."""
        return self._selected(slice(None), tuple(joint_names))

    def _selected(self, rows: slice, names: tuple[str, ...]) -> JointTrajectory:
        columns = [self.joint_names.index(name) for name in names]
        tables = {what: getattr(self, what) for what in QUANTITIES}
        return replace(self, joint_names=names, times=self.times[rows], **{
            what: values[rows, columns] for what, values in tables.items() if values is not None})


def _table(
    names: Sequence[str], what: str, rows: Sequence[Sequence[float]]
) -> tuple[Matrix, str]:
    """Return a quantity of all points (k, n), and what is wrong with it: then it is all NaN."""
    table = np.full((len(rows), len(names)), np.nan)
    for k, row in enumerate(rows):
        if len(row) not in (0, len(names)):
            return np.full_like(table, np.nan), (
                f'point {k} has {len(row)} {what} for {len(names)} joints; '
                f'allowed: {len(names)} or none')
        if len(row):
            table[k] = row
    given = np.array([len(row) > 0 for row in rows], dtype=np.bool_)
    odd = given[:, None] & ~np.isfinite(table)
    if odd.any():
        return np.full_like(table, np.nan), _not_finite(names, what, table, odd)
    return table, ''


def _not_finite(names: Sequence[str], what: str, values: Matrix, odd: Mask) -> str:
    """Return a sentence about the first number that is not finite."""
    k, j = np.argwhere(odd)[0]
    return (f"point {k} has {values[k, j]} among its {what}, for joint '{names[j]}'; allowed: "
            'finite numbers')
