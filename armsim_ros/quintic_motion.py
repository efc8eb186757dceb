# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Quintic and lower polynomials between points: a timed motion as a controller runs it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.trajectory import JointTrajectory

DEGREE = 5
LINEAR, CUBIC, QUINTIC = 0, 1, 2


def hermite_coefficients(
    durations: Vector, levels: NDArray[np.int64], start: Matrix, end: Matrix
) -> Matrix:
    """
    Return the coefficients of k segments of n joints.

    :param durations: (k,) T of each segment, positive [s].
    :param levels: (k,) LINEAR, CUBIC or QUINTIC.
    :param start: (3, k, n) position, velocity, acceleration at the start; derivatives that the
        level does not use may be NaN.
    :param end: (3, k, n) the same at the end.
    :returns: (k, 6, n) in powers of u.
    """
    T = durations[:, None]
    p0, p1 = start[0], end[0]
    cubic = (levels >= CUBIC)[:, None]
    quintic = (levels >= QUINTIC)[:, None]
    v0, v1 = np.where(cubic, start[1], 0.0) * T, np.where(cubic, end[1], 0.0) * T
    a0, a1 = (np.where(quintic, x[2], 0.0) * (0.5 * T * T) for x in (start, end))
    d = p1 - p0
    joints = p0.shape[1]
    c = np.zeros((len(durations), DEGREE + 1, joints))
    c[:, 0] = p0
    c[:, 1] = np.where(cubic, v0, d)
    c[:, 2] = np.where(quintic, a0, np.where(cubic, 3.0 * d - 2.0 * v0 - v1, 0.0))
    c[:, 3] = np.where(
        quintic, 10.0 * d - 6.0 * v0 - 4.0 * v1 - 3.0 * a0 + a1,
        np.where(cubic, v0 + v1 - 2.0 * d, 0.0))
    c[:, 4] = np.where(quintic, -15.0 * d + 8.0 * v0 + 7.0 * v1 + 3.0 * a0 - 2.0 * a1, 0.0)
    c[:, 5] = np.where(quintic, 6.0 * d - 3.0 * (v0 + v1) - a0 + a1, 0.0)
    return c


def with_derivatives(position: Matrix, durations: Vector) -> Matrix:
    """
    Put the coefficients of velocity and acceleration beside those of the position.

    :param position: (k, 6, n) in powers of u.
    :param durations: (k,) [s].
    :returns: (k, 6, 3n).
    """
    joints = position.shape[2]
    full = np.zeros((*position.shape[:2], 3 * joints))
    powers = np.arange(1, DEGREE + 1)[None, :, None]
    rate = 1.0 / durations[:, None, None]
    full[:, :, :joints] = position
    full[:, :-1, joints : 2 * joints] = position[:, 1:] * powers * rate
    full[:, :-1, 2 * joints :] = full[:, 1:, joints : 2 * joints] * powers * rate
    return full


def powers(u: Vector) -> Matrix:
    """Return 1, u, .., u^5 as (m, 6) for u (m,)."""
    return u[:, None] ** np.arange(DEGREE + 1)


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
    def _coefficients(self) -> Matrix:
        """Of the positions (k - 1, 6, n)."""
        states = np.stack([self.positions, self.velocities, self.accelerations])
        h = np.diff(self.times)
        return hermite_coefficients(h, np.full(len(h), QUINTIC), states[:, :-1], states[:, 1:])

    @cached_property
    def _derivatives(self) -> Matrix:
        """Of positions, velocities and accelerations (k - 1, 6, 3n)."""
        return with_derivatives(self._coefficients, np.diff(self.times))

    @property
    def duration(self) -> float:
        """Time of the last point [s]."""
        return float(self.times[-1])

    @classmethod
    def of(
        cls, trajectory: JointTrajectory, standing: Mapping[str, float] | None = None
    ) -> QuinticMotion:
        """
        Return a trajectory whose points have velocities and accelerations.

        :param standing: joint -> its position [rad or m] if the trajectory does not move it;
            gives the joints and their order. None for the joints of the trajectory.
        """
        given = np.array([trajectory.positions, trajectory.velocities, trajectory.accelerations])
        if standing is None:
            return cls(trajectory.times, *given)
        joints, names = list(standing), trajectory.joint_names
        states = np.zeros((3, len(trajectory), len(joints)))
        states[0] = list(standing.values())
        common = [name for name in names if name in standing]
        states[:, :, list(map(joints.index, common))] = given[:, :, list(map(names.index, common))]
        return cls(trajectory.times, *states)

    @classmethod
    def at_rest(cls, positions: Vector) -> QuinticMotion:
        """Return a point (n,) in which nothing moves."""
        return cls(np.zeros(1), positions[None], *(np.zeros((1, len(positions))),) * 2)

    def sample(self, t: Vector) -> Vector:
        """Return the positions (m, n) at times t (m,) [s]; the ends hold outside."""
        part, u = self._places(t)
        positions: Vector = np.einsum('mc,mcn->mn', powers(u), self._coefficients[part])
        return positions

    def states(self, t: Vector) -> tuple[Vector, Vector, Vector]:
        """
        Return positions, velocities and accelerations, (m, n) each, at times t (m,) [s].

        Outside the joints are where the motion ends.
        """
        part, u = self._places(t)
        values = np.einsum('mc,mcn->mn', powers(u), self._derivatives[part])
        position, velocity, acceleration = np.split(values, 3, axis=1)
        moving = ((t >= 0.0) & (t <= self.duration))[:, None]
        return position, np.where(moving, velocity, 0.0), np.where(moving, acceleration, 0.0)

    def _places(self, t: Vector) -> tuple[NDArray[np.intp], Vector]:
        """Return the part and the share 0..1 of it for each time."""
        inside = np.clip(t, 0.0, self.duration)
        last = len(self.times) - 2
        part = np.clip(np.searchsorted(self.times, inside, side='right') - 1, 0, last)
        h = self.times[part + 1] - self.times[part]
        return part, (inside - self.times[part]) / h

    def peaks(self, per_part: int = 10) -> tuple[Vector, Vector]:
        """
        Return the largest speed and acceleration of every joint, between the points too.

        :param per_part: samples between two points.
        :returns: (n,) [rad/s or m/s] and (n,) [rad/s^2 or m/s^2].
        """
        joints = self.positions.shape[1]
        rates = np.abs(
            powers(np.linspace(0.0, 1.0, per_part + 1)) @ self._derivatives[:, :, joints:]
        ).max(axis=(0, 1))
        return rates[:joints], rates[joints:]

    def slowed(self, factor: float) -> QuinticMotion:
        """Return the same motion with all times multiplied by a factor >= 1."""
        motion = QuinticMotion(
            self.times * factor, self.positions, self.velocities / factor,
            self.accelerations / factor**2)
        # Over the share of the time between two points it is the same polynomial.
        vars(motion)['_coefficients'] = self._coefficients
        return motion

    def part(self, begin: int, end: int | None = None) -> QuinticMotion:
        """Return some of the points, at their times."""
        rows = slice(begin, end)
        return QuinticMotion(self.times[rows], self.positions[rows], self.velocities[rows],
                             self.accelerations[rows])

    def joined(self, other: QuinticMotion, offset: float) -> QuinticMotion:
        """Return the points of both motions, those of the other later by an offset [s]."""
        return QuinticMotion(
            np.concatenate([self.times, other.times + offset]),
            np.concatenate([self.positions, other.positions]),
            np.concatenate([self.velocities, other.velocities]),
            np.concatenate([self.accelerations, other.accelerations]))

    def then(self, other: QuinticMotion) -> QuinticMotion:
        """Return this motion, a stop, and a motion that begins where this motion ends."""
        return self.joined(other.part(1), self.duration)

    def trajectory(self, joint_names: Sequence[str]) -> JointTrajectory:
        """Return the points as a trajectory of these joints."""
        return JointTrajectory(tuple(joint_names), self.times, self.positions, self.velocities,
                               self.accelerations)
