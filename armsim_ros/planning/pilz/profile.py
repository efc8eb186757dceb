# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How a motion gathers speed, keeps it, and comes to rest: point to point, along a curve."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
import math

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.planning.cartesian.curves import Curve, CurveFollower
from armsim_ros.planning.timing.limits import MotionLimits
from armsim_ros.quintic_motion import QuinticMotion

ROUNDING = 0.05
"""Time [s] over which the acceleration changes from one value to the next."""

PRECISION = 5e-4
"""Largest distance [m] of a link from its curve between two points."""

_MOST_HALVINGS = 5


class TrapezoidalProfile:
    """
    A path from 0 to 1 with a trapezoidal speed whose corners are rounded.

    The moving average of a trapezoidal profile over :data:`ROUNDING`: speed and acceleration
    keep their limits, and between two knots the position is a polynomial of degree three.

    :param speed: largest rate [1/s].
    :param acceleration: [1/s^2] up to that rate.
    :param deceleration: [1/s^2] down to rest.
    """

    def __init__(self, speed: float, acceleration: float, deceleration: float) -> None:
        peak = min(speed, math.sqrt(
            2.0 * acceleration * deceleration / (acceleration + deceleration)
        ))
        rates = np.array([acceleration, 0.0, -deceleration, 0.0])
        lengths = np.array([peak / acceleration, 0.0, peak / deceleration])
        lengths[1] = max(0.0, 1.0 - 0.5 * peak * (lengths[0] + lengths[2])) / peak
        self._rates = rates
        self._begins = np.concatenate([[0.0], np.cumsum(lengths)])
        self._speeds = np.array([0.0, peak, peak, 0.0])
        places, areas = [0.0], [0.0]
        for k, t in enumerate(lengths):
            v, a = self._speeds[k], rates[k]
            areas.append(areas[-1] + places[-1] * t + v * t**2 / 2.0 + a * t**3 / 6.0)
            places.append(places[-1] + v * t + a * t**2 / 2.0)
        places[-1] = 1.0
        self._places, self._areas = np.array(places), np.array(areas)

    @property
    def duration(self) -> float:
        """Time to the end [s]."""
        return float(self._begins[-1]) + ROUNDING

    def times(self, step: float) -> Vector:
        """Return the knots and, between them, times that are at most ``step`` [s] apart."""
        knots = np.unique(np.round(np.concatenate([self._begins, self._begins + ROUNDING]), 9))
        parts = [
            np.linspace(a, b, math.ceil((b - a) / step - 1e-9), endpoint=False)
            for a, b in pairwise(knots)
        ]
        return np.concatenate([*parts, knots[-1:]])

    def sample(self, times: Vector) -> tuple[Vector, Vector, Vector]:
        """
        Return place 0..1, speed [1/s] and acceleration [1/s^2] at times (k,) [s].

        :returns: (k,) each.
        """
        now, before = self._raw(times), self._raw(times - ROUNDING)
        place, speed, acceleration = (
            (a - b) / ROUNDING for a, b in zip(now, before, strict=True)
        )
        return np.clip(place, 0.0, 1.0), speed, acceleration

    def _raw(self, times: Vector) -> tuple[Vector, Vector, Vector]:
        """Return the plain profile's area, place and speed."""
        inside = np.maximum(times, 0.0)
        phase = np.clip(np.searchsorted(self._begins, inside, side='right') - 1, 0, 3)
        t = inside - self._begins[phase]
        v, a = self._speeds[phase], self._rates[phase]
        place = self._places[phase]
        return (
            self._areas[phase] + place * t + v * t**2 / 2.0 + a * t**3 / 6.0,
            place + v * t + a * t**2 / 2.0,
            v + a * t,
        )


def point_to_point(
    start: Vector, end: Vector, limits: MotionLimits, step: float
) -> QuinticMotion:
    """
    Return the fastest motion in which all joints start and stop together.

    :param start: (m,) at rest.
    :param end: (m,) at rest.
    :param step: largest time between two points [s].
    """
    way = end - start
    share = np.maximum(np.abs(way), 1e-12)
    acceleration = float(np.min(limits.acceleration / share))
    profile = TrapezoidalProfile(
        float(np.min(limits.velocity / share)), acceleration, acceleration
    )
    times = profile.times(step)
    place, speed, rate = (values[:, None] for values in profile.sample(times))
    return QuinticMotion(times, start + place * way, speed * way, rate * way)


def along_curve(
    follower: CurveFollower, start: Vector, curve: Curve, profile: TrapezoidalProfile,
    step: float, check: Callable[[], None],
) -> QuinticMotion:
    """
    Return the joint motion that takes a frame along a curve.

    :param start: (m,) the group's values at the curve's beginning.
    :param profile: when the frame is where.
    :param step: largest time between two points [s]; smaller ones are taken where the link
        would leave the curve by more than :data:`PRECISION`.
    :param check: called now and then; raises where the request was cancelled.
    :raises PlanningError: FAILURE where the arm cannot follow.
    """
    for _ in range(_MOST_HALVINGS):
        check()
        motion = _sampled(follower, start, curve, profile, profile.times(step))
        middles = 0.5 * (motion.times[1:] + motion.times[:-1])
        places = profile.sample(middles)[0]
        if all(
            follower.distance(values, curve.pose(float(place)))[0] <= PRECISION
            for place, values in zip(places, motion.sample(middles), strict=True)
        ):
            return motion
        step *= 0.5
    raise PlanningError(
        MoveItErrorCode.FAILURE,
        f"the joints would have to jump for '{follower.frame.link}' to stay on its path; begin "
        'in another posture, or keep away from the singularity', 'link path',
    )


def _sampled(
    follower: CurveFollower, start: Vector, curve: Curve, profile: TrapezoidalProfile,
    times: Vector,
) -> QuinticMotion:
    place, speed, rate = profile.sample(times)
    states, slopes = [], []
    values = start
    for s in map(float, place):
        found, result = follower.solve(curve.pose(s), values)
        if found is None:
            raise PlanningError(
                MoveItErrorCode.FAILURE,
                f"'{follower.frame.link}' cannot follow its path beyond {s:.0%} of it: "
                f'{result.message}', 'link path',
            )
        values = found
        states.append(values)
        slopes.append(follower.slope(values, curve.twist(s)))
    slope = np.array(slopes)
    distinct = np.concatenate([[True], np.diff(place) > 1e-9])
    bend = np.zeros_like(slope)
    if np.count_nonzero(distinct) > 2:
        bend[distinct] = np.gradient(slope[distinct], place[distinct], axis=0)
    return QuinticMotion(
        times,
        np.array(states),
        slope * speed[:, None],
        bend * speed[:, None] ** 2 + slope * rate[:, None],
    )
