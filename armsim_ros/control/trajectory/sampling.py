# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
From waypoints to a motion that is sampled in every update, and motions that stop.

The segments between the waypoints do not depend on when the motion starts; they are computed
where the trajectory arrives (:class:`PreparedTrajectory`). What leads from the current state to
the first waypoint is added when the control loop takes it up (:class:`Motion`).
"""

from __future__ import annotations

from collections.abc import Sequence
import math

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.control.trajectory.waypoints import Waypoints, whole_turns
from armsim_ros.quintic_motion import DEGREE, hermite_coefficients, QUINTIC, with_derivatives


def spline_coefficients(
    durations: Matrix, levels: NDArray[np.int64], start: Matrix, end: Matrix
) -> Matrix:
    """
    Return the coefficients (k, 6, 3n) of k segments of n joints and of their derivatives.

    Parameters are those of :func:`armsim_ros.quintic_motion.hermite_coefficients`.
    """
    return with_derivatives(hermite_coefficients(durations, levels, start, end), durations)


def with_effort(coefficients: Matrix, start: Matrix, end: Matrix) -> Matrix:
    """
    Put linear effort beside the motion.

    :param coefficients: (k, 6, 3n).
    :param start: (k, n) effort at the start of each segment [N*m or N].
    :param end: (k, n) effort at the end.
    :returns: (k, 6, 4n).
    """
    effort = np.zeros((*coefficients.shape[:2], start.shape[1]))
    effort[:, 0] = start
    effort[:, 1] = end - start
    return np.concatenate((coefficients, effort), axis=2)


def step_coefficients(end: Matrix) -> Matrix:
    """
    Return segments that rest at the values of their end, for the method ``none``.

    :param end: (k, w) all values of the waypoint at each segment's end.
    :returns: (k, 6, w).
    """
    c = np.zeros((end.shape[0], DEGREE + 1, end.shape[1]))
    c[:, 0] = end
    return c


def coefficients_between(
    begins: Waypoints, ends: Waypoints, *, splines: bool, effort: bool
) -> Matrix:
    """
    Return the coefficients of the m - 1 segments between m waypoints.

    :param begins: with a position for every joint, and the derivatives where segments begin.
    :param ends: the same points, and the derivatives where segments end.
    :param splines: polynomials; else every segment rests at its end point's values.
    :param effort: whether effort is interpolated too.
    """
    if not splines:
        return step_coefficients(point_values(ends, effort=effort)[1:])
    start, end = (
        np.stack((points.positions, points.velocities, points.accelerations))
        for points in (begins, ends))
    levels = np.minimum(begins.levels[:-1], ends.levels[1:])
    c = spline_coefficients(np.diff(ends.times), levels, start[:, :-1], end[:, 1:])
    return with_effort(c, ends.effort[:-1], ends.effort[1:]) if effort else c


def point_values(waypoints: Waypoints, *, effort: bool) -> Matrix:
    """Return (m, 3n) or, with effort, (m, 4n) values of the points, 0 where not given."""
    blocks = [waypoints.positions, waypoints.velocities, waypoints.accelerations]
    if effort:
        blocks.append(waypoints.effort)
    return np.nan_to_num(np.concatenate(blocks, axis=1), nan=0.0)


TIME_RESOLUTION = 1e-9
"""Times nearer than this are the same [s]."""


class Motion:
    """
    A piecewise polynomial from a start time to an end time, and the state it ends in.

    :param start: time of the first value [s].
    :param ends: (k,) increasing end times of the segments [s]; empty rests from the start.
    :param coefficients: (k, 6, w) as the functions above make them.
    :param final: (w,) values after the last segment.
    """

    __slots__ = ('_begins', '_coefficients', '_ends', '_rates', 'end', 'final', 'start')

    def __init__(
        self, start: float, ends: Sequence[float], coefficients: Matrix, final: Vector
    ) -> None:
        self.start = start
        self.end = ends[-1] if len(ends) else start
        self.final = final
        self._ends = np.array(ends, dtype=np.float64)
        self._begins = np.concatenate(([start], self._ends[:-1]))[: len(self._ends)]
        self._rates = 1.0 / (self._ends - self._begins)
        self._coefficients = coefficients

    @classmethod
    def standing(cls, final: Vector, time: float = 0.0) -> Motion:
        """Return a motion that rests at (w,) ``final`` for ever."""
        return cls(time, (), np.empty((0, DEGREE + 1, len(final))), final)

    def over(self, time: float) -> bool:
        """Return whether the final values hold from this time on [s]."""
        return time > self.end or not len(self._ends)

    def samples(self, times: Vector) -> Matrix:
        """
        Return the (k, w) values at some times; after the end the final values hold.

        What comes out for a time does not depend on the other times, not by a bit.

        :param times: (k,) [s].
        """
        if not len(self._ends):
            return np.tile(self.final, (len(times), 1))
        segment = np.minimum(np.searchsorted(self._ends, times), len(self._ends) - 1)
        u = ((times - self._begins[segment]) * self._rates[segment])[:, None]
        if segment[0] == segment[-1] and (len(segment) < 3 or (segment == segment[0]).all()):
            powers = self._coefficients[segment[0]][:, None]
        else:
            powers = self._coefficients[segment].swapaxes(0, 1)
        values: Matrix = powers[DEGREE] * u
        for power in range(DEGREE - 1, 0, -1):
            values += powers[power]
            values *= u
        values += powers[0]
        values[times > self.end] = self.final
        return values

    def at(self, time: float) -> Vector:
        """Return the (w,) values at a time [s]."""
        values: Vector = self.samples(np.array([time]))[0]
        return values


class PreparedTrajectory:
    """
    Waypoints with the segments between them, ready to be started.

    :param waypoints: as validated; may lack positions that are only known at the start.
    :param continuous: indices of the joints that turn without end.
    :param splines: False for the interpolation method ``none``.
    :param effort: whether effort is part of the motion.
    :param rest_at_end: rest after the last point, whatever velocity it gives.
    """

    def __init__(
        self, waypoints: Waypoints, continuous: NDArray[np.intp] | None = None, *,
        splines: bool = True, effort: bool = False, rest_at_end: bool = False
    ) -> None:
        self.waypoints = waypoints
        self._continuous = np.empty(0, dtype=np.intp) if continuous is None else continuous
        self._splines, self._effort, self._rest_at_end = splines, effort, rest_at_end
        self._between: Matrix | None = None
        if waypoints.complete:
            self._between = coefficients_between(
                waypoints, waypoints, splines=splines, effort=effort)

    def start_ns(self, stamp_ns: int) -> int:
        """
        Return from when on the joints move to the first point [ns]: the stamp, 0 for at once.

        A first point at the stamp itself would leave them no time.
        """
        return stamp_ns if self.waypoints.times[0] > TIME_RESOLUTION else 0

    def begin(self, time: float, state: Vector, held: Vector, *, step: bool = False) -> Motion:
        """
        Return the motion from a state on.

        Points that are in the past are left out; the first that is not is reached by a segment
        from ``state``. A point at ``time`` itself gives the derivatives that the motion starts
        with, and with ``step`` its position too. Joints that turn without end take the short
        way: the whole trajectory is moved by whole turns, the state is not.

        :param time: trajectory time of ``state`` [s]; after the last point the motion rests there.
        :param state: (3n,) or (4n,) position, velocity, acceleration (and effort).
        :param held: (n,) positions of the joints that the trajectory does not name.
        """
        joints = len(held)
        full = begins = self.waypoints
        between = self._between
        time = min(time, float(full.times[-1]))
        if between is None:
            full, begins = full.held(held).integrated(
                time, state[: 3 * joints].reshape(3, joints))
            between = coefficients_between(
                begins, full, splines=self._splines, effort=self._effort)
        times = full.times
        first = int(np.searchsorted(times, time + TIME_RESOLUTION, side='right'))
        at_start = first > 0 and math.isclose(times[first - 1], time, abs_tol=TIME_RESOLUTION)
        nearest = full.positions[first - 1 if at_start else first]
        offset = np.zeros(joints)
        offset[self._continuous] = whole_turns((nearest - state[:joints])[self._continuous])
        if offset.any():
            full = full.shifted(offset)
            between = between.copy()
            between[:, 0, :joints] -= offset
        final = point_values(full, effort=self._effort)[-1]
        if self._rest_at_end:
            final[joints : 3 * joints] = 0.0
        if first == len(times):
            return Motion.standing(final, time)
        lead_in = self._lead_in(full, begins, first, time, state, at_start=at_start, step=step)
        return Motion(
            time, times[first:].tolist(), np.concatenate((lead_in, between[first:])), final)

    def _lead_in(
        self, full: Waypoints, begins: Waypoints, first: int, time: float, state: Vector, *,
        at_start: bool, step: bool
    ) -> Matrix:
        joints = len(full.named)
        states = state[: 3 * joints].reshape(3, 1, joints).copy()
        level = QUINTIC
        if at_start:
            row = first - 1
            level = int(begins.levels[row])
            states[1:, 0] = np.nan_to_num((begins.velocities[row], begins.accelerations[row]))
            if step:
                states[0, 0] = full.positions[row]
        if not self._splines:
            width = joints * (4 if self._effort else 3)
            if at_start:
                return step_coefficients(
                    point_values(full, effort=self._effort)[first : first + 1])
            return step_coefficients(state[None, :width])
        rows = slice(first, first + 1)
        ends = np.stack((full.positions[rows], full.velocities[rows], full.accelerations[rows]))
        levels = np.minimum(full.levels[rows], level)
        durations = full.times[rows] - time
        c = spline_coefficients(durations, levels, states, ends)
        if self._effort:
            effort = full.effort[first - 1 : first] if at_start else state[None, 3 * joints :]
            c = with_effort(c, effort, full.effort[rows])
        return c


def standstill(position: Vector, width: int) -> Motion:
    """
    Stay at a position for ever.

    :param position: (n,) [rad or m].
    :param width: 3n, or 4n where the motion has effort, which is 0.
    """
    final = np.zeros(width)
    final[: len(position)] = position
    return Motion.standing(final)


def deceleration(position: Vector, velocity: Vector, maximum: Vector, width: int) -> Motion:
    """
    Brake every joint with its own constant deceleration.

    A joint with velocity v comes to rest after |v| / a and v^2 / (2 a) further on.

    :param position: (n,) [rad or m].
    :param velocity: (n,) [rad/s or m/s].
    :param maximum: (n,) positive decelerations [rad/s^2 or m/s^2].
    :param width: 3n, or 4n where the motion has effort, which is 0.
    """
    durations = np.abs(velocity) / maximum
    rest = position + velocity * durations / 2.0
    joints = len(position)
    ends = np.unique(durations[durations > 1e-9])
    if not len(ends):
        return standstill(rest, width)
    begins = np.concatenate(([0.0], ends[:-1]))
    T = (ends - begins)[:, None]
    brakes = durations > begins[:, None] + 1e-12
    remaining = np.where(brakes, durations - begins[:, None], 0.0)
    a = -np.sign(velocity) * maximum
    c = np.zeros((len(ends), DEGREE + 1, joints))
    c[:, 0] = rest + 0.5 * a * remaining**2
    c[:, 1] = -a * remaining * T
    c[:, 2] = np.where(brakes, 0.5 * a * T**2, 0.0)
    full = with_derivatives(c, ends - begins)
    if width > 3 * joints:
        full = with_effort(full, *np.zeros((2, len(ends), joints)))
    return Motion(0.0, ends.tolist(), full, standstill(rest, width).final)


def stop_ramp(position: Vector, velocity: Vector, duration: float, width: int) -> Motion:
    """
    Come to rest on a quintic within a time, as ``stop_trajectory_duration`` of ROS 1 asks.

    The resting position is the middle of the quintic that turns velocity v into -v within twice
    the duration D; it lies 0.625 * v * D further on.

    :param position: (n,) of the reference [rad or m].
    :param velocity: (n,) of the reference [rad/s or m/s].
    :param duration: D, positive [s].
    :param width: 3n, or 4n where the motion has effort, which is 0.
    """
    zero = np.zeros_like(position)
    there = np.stack((position, velocity, zero))[:, None]
    back = np.stack((position, -velocity, zero))[:, None]
    quintic = np.array([QUINTIC])
    turning = spline_coefficients(np.array([2.0 * duration]), quintic, there, back)
    middle = 0.5 ** np.arange(DEGREE + 1) @ turning[0]
    rest = np.stack((middle[: len(position)], zero, zero))[:, None]
    ramp = spline_coefficients(np.array([duration]), quintic, there, rest)
    if width > 3 * len(position):
        ramp = with_effort(ramp, zero[None], zero[None])
    return Motion(0.0, [duration], ramp, standstill(rest[0, 0], width).final)
