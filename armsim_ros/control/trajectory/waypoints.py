# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A trajectory's points as arrays in the controller's joint order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.trajectory import JointTrajectory

TURN = 2.0 * math.pi
ROUNDING = 1e-12


def whole_turns(displacement: Vector) -> Vector:
    """
    Return the whole turns in a displacement [rad], such that at most half a turn remains.

    Exactly half a turn keeps its sign.
    """
    turns = np.ceil(np.abs(displacement) / TURN - 0.5 - ROUNDING)
    return np.asarray(np.copysign(turns * TURN, displacement))


def shortest(displacement: Vector) -> Vector:
    """Return displacements [rad] without their whole turns."""
    return displacement - whole_turns(displacement)


def wrap_in_place(errors: Vector, continuous: NDArray[np.intp]) -> None:
    """
    Take the whole turns out of the errors of the continuous joints.

    :param errors: (n,) [rad], changed in place.
    :param continuous: indices of the continuous joints.
    """
    part = errors[continuous]
    errors[continuous] = part - np.rint(part / TURN) * TURN


@dataclass(frozen=True, slots=True, eq=False)
class Waypoints:
    """
    Points of n joints; NaN where a point does not give a value.

    :param times: (m,) from the trajectory's start [s].
    :param positions: (m, n) [rad or m].
    :param velocities: (m, n) [rad/s or m/s].
    :param accelerations: (m, n) [rad/s^2 or m/s^2].
    :param effort: (m, n) [N*m or N], 0 where a point gives none.
    :param named: (n,) the joints that the trajectory names; the others are held.
    """

    times: Matrix
    positions: Matrix
    velocities: Matrix
    accelerations: Matrix
    effort: Matrix
    named: Mask

    @classmethod
    def of(cls, trajectory: JointTrajectory, joints: Sequence[str]) -> Waypoints:
        """
        Sort the values of a checked trajectory by the controller's joints.

        Joints that it does not name get no position, and 0 for each derivative that the point
        gives for the others.
        """
        columns = np.array([joints.index(name) for name in trajectory.joint_names], dtype=np.intp)
        named = np.zeros(len(joints), dtype=np.bool_)
        named[columns] = True

        def table(values: Matrix | None, others: float, lacking: float = np.nan) -> Matrix:
            """Return (m, n): ``others`` in joints that are not named, ``lacking`` rows."""
            full = np.full((len(trajectory), len(joints)), lacking)
            if values is not None:
                given = ~np.isnan(values).any(axis=1)
                full[given] = others
                full[np.ix_(given, columns)] = values[given]
            return full

        return cls(
            trajectory.times, table(trajectory.positions, np.nan),
            table(trajectory.velocities, 0.0), table(trajectory.accelerations, 0.0),
            table(trajectory.effort, 0.0, 0.0), named)

    @property
    def complete(self) -> bool:
        """Whether every point has a position for every joint."""
        return not bool(np.isnan(self.positions).any())

    @property
    def levels(self) -> NDArray[np.int64]:
        """(m,) derivatives known at each point: 0 position, 1 + velocity, 2 + acceleration."""
        velocity = ~np.isnan(self.velocities).any(axis=1)
        acceleration = ~np.isnan(self.accelerations).any(axis=1)
        return np.asarray(velocity.astype(np.int64) + (velocity & acceleration))

    def held(self, positions: Matrix) -> Waypoints:
        """
        Give the joints that the trajectory does not name the same position at every point.

        :param positions: (n,) where they are held [rad or m].
        """
        if self.named.all():
            return self
        filled = self.positions.copy()
        with_positions = ~np.isnan(filled[:, self.named]).any(axis=1)
        filled[np.ix_(with_positions, ~self.named)] = positions[~self.named]
        return replace(self, positions=filled)

    def integrated(self, time: float, start: Matrix) -> tuple[Waypoints, Waypoints]:
        """
        Fill missing velocities and positions with the trapezoid rule, point after point.

        The rule takes derivatives that the point before lacks as 0. The segment between the two
        begins with them; the segment before ends without.

        :param time: when the start state holds [s].
        :param start: (3, n) position, velocity, acceleration before the first point.
        :returns: the points where segments end, and where they begin.
        """
        if self.complete:
            return self, self
        positions, velocities = self.positions.copy(), self.velocities.copy()
        begin_velocities, begin_accelerations = velocities.copy(), self.accelerations.copy()
        p, v, a = start
        for row, now in enumerate(self.times):
            dt = now - time
            a_next = self.accelerations[row]
            a_next = np.where(np.isnan(a_next), 0.0, a_next)
            if np.isnan(positions[row]).any():
                if row:
                    begin_velocities[row - 1] = v
                if np.isnan(velocities[row]).any():
                    velocities[row] = v + 0.5 * dt * (a + a_next)
                    if row:
                        begin_accelerations[row - 1] = a
                missing = np.isnan(positions[row])
                positions[row, missing] = (p + 0.5 * dt * (v + velocities[row]))[missing]
            p, a, time = positions[row], a_next, now
            begin_velocities[row] = velocities[row]
            v = np.where(np.isnan(velocities[row]), 0.0, velocities[row])
        ends = replace(self, positions=positions, velocities=velocities)
        return ends, replace(
            ends, velocities=begin_velocities, accelerations=begin_accelerations)

    def shifted(self, offset: Matrix) -> Waypoints:
        """Subtract (n,) ``offset`` [rad or m] from every position."""
        return replace(self, positions=self.positions - offset)
