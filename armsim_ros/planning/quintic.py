# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A timed motion as a trajectory controller runs it: quintic splines between its points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from armsim_ros.trajectory import JointTrajectory, TrajectoryPoint

Vector = NDArray[np.float64]

# Rows: coefficients of 1, x, .. x^5 with x = t / h; columns: p0, v0*h, a0*h^2, p1, v1*h, a1*h^2.
_BASIS = np.array(
    [
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.5, 0.0, 0.0, 0.0],
        [-10.0, -6.0, -1.5, 10.0, -4.0, 0.5],
        [15.0, 8.0, 1.5, -15.0, 7.0, -1.0],
        [-6.0, -3.0, -0.5, 6.0, -3.0, 0.5],
    ]
)


@dataclass(frozen=True, eq=False)
class QuinticMotion:
    """
    Points with position, velocity and acceleration.

    :param times: (k,) [s], increasing from 0.
    :param positions: (k, n) [rad or m].
    :param velocities: (k, n) [rad/s or m/s].
    :param accelerations: (k, n) [rad/s^2 or m/s^2].
    """

    times: Vector
    positions: Vector
    velocities: Vector
    accelerations: Vector

    @cached_property
    def _coefficients(self) -> Vector:
        h = np.diff(self.times)[:, None]
        ends = np.stack(
            [
                self.positions[:-1], self.velocities[:-1] * h, self.accelerations[:-1] * h**2,
                self.positions[1:], self.velocities[1:] * h, self.accelerations[1:] * h**2,
            ],
            axis=1,
        )
        coefficients: Vector = np.einsum('ck,skn->scn', _BASIS, ends)
        return coefficients

    @property
    def duration(self) -> float:
        """Time of the last point [s]."""
        return float(self.times[-1])

    @classmethod
    def of(cls, trajectory: JointTrajectory) -> QuinticMotion:
        """Return a trajectory whose points have velocities and accelerations."""
        points = trajectory.points
        return cls(
            trajectory.times(),
            trajectory.positions(),
            np.array([point.velocities for point in points]),
            np.array([point.accelerations for point in points]),
        )

    def sample(self, t: Vector) -> Vector:
        """Return the positions (m, n) at times t (m,) [s]; the ends hold outside."""
        part, _, x = self._places(t)
        powers = x[:, None] ** np.arange(6)
        positions: Vector = np.einsum('mc,mcn->mn', powers, self._coefficients[part])
        return positions

    def states(self, t: Vector) -> tuple[Vector, Vector, Vector]:
        """
        Return positions, velocities and accelerations, (m, n) each, at times t (m,) [s].

        Outside the joints stand where the motion ends.
        """
        part, h, x = self._places(t)
        coefficients, moving = self._coefficients[part], (t >= 0.0) & (t <= self.duration)
        degree = np.arange(6)
        values = [self.sample(t)]
        for order in (1, 2):
            factor = np.ones(6)
            for lower in range(order):
                factor *= degree - lower
            powers = factor * x[:, None] ** np.maximum(degree - order, 0)
            slope = np.einsum('mc,mcn->mn', powers, coefficients) / h[:, None] ** order
            values.append(np.where(moving[:, None], slope, 0.0))
        return values[0], values[1], values[2]

    def _places(self, t: Vector) -> tuple[NDArray[np.intp], Vector, Vector]:
        """Return the part, its duration [s] and the share of it for each time."""
        inside = np.clip(t, 0.0, self.duration)
        last = len(self.times) - 2
        part = np.clip(np.searchsorted(self.times, inside, side='right') - 1, 0, last)
        h = self.times[part + 1] - self.times[part]
        return part, h, (inside - self.times[part]) / h

    def peaks(self, per_part: int = 10) -> tuple[Vector, Vector]:
        """
        Return the largest speed and acceleration of every joint, between the points too.

        :param per_part: samples between two points.
        :returns: (n,) [rad/s or m/s] and (n,) [rad/s^2 or m/s^2].
        """
        x = np.linspace(0.0, 1.0, per_part + 1)
        degree = np.arange(6)
        first = np.zeros((len(x), 6))
        first[:, 1:] = degree[1:] * x[:, None] ** (degree[1:] - 1)
        second = np.zeros((len(x), 6))
        second[:, 2:] = degree[2:] * (degree[2:] - 1) * x[:, None] ** (degree[2:] - 2)
        h = np.diff(self.times)[:, None, None]
        velocity = np.abs(np.einsum('xc,scn->sxn', first, self._coefficients) / h)
        acceleration = np.abs(np.einsum('xc,scn->sxn', second, self._coefficients) / h**2)
        return velocity.max(axis=(0, 1)), acceleration.max(axis=(0, 1))

    def slowed(self, factor: float) -> QuinticMotion:
        """Return the same motion with all times multiplied by a factor >= 1."""
        return QuinticMotion(
            self.times * factor,
            self.positions,
            self.velocities / factor,
            self.accelerations / factor**2,
        )

    def trajectory(self, joint_names: Sequence[str]) -> JointTrajectory:
        """Return the points as a trajectory of these joints."""
        return JointTrajectory(
            tuple(joint_names),
            tuple(
                TrajectoryPoint(float(t), p.copy(), v.copy(), a.copy())
                for t, p, v, a in zip(
                    self.times, self.positions, self.velocities, self.accelerations, strict=True
                )
            ),
        )
