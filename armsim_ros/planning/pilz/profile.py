# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Trapezoidal speed profiles, their samples, and the point-to-point motion."""

from __future__ import annotations

from collections.abc import Iterator
import math

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.planning.timing.limits import MotionLimits
from armsim_ros.quintic_motion import QuinticMotion

SAMPLING_TIME = 0.1
"""Time [s] between two points of a trajectory; the last interval may be shorter."""

_SHORTEST_INTERVAL = 1e-5


class TrapezoidalProfile:
    """
    The fastest motion over a distance with limited speed and acceleration, from rest to rest.

    :param distance: [m or rad], >= 0.
    :param speed: largest speed [m/s or rad/s].
    :param acceleration: largest acceleration and deceleration [m/s^2 or rad/s^2].
    """

    def __init__(self, distance: float, speed: float, acceleration: float) -> None:
        self._distance = distance
        self._acceleration = acceleration
        self._peak = min(speed, math.sqrt(distance * acceleration))
        self._ramp = self._peak / acceleration
        cruise = (distance - self._peak * self._ramp) / self._peak if self._peak else 0.0
        #: Time to the end [s].
        self.duration = 2.0 * self._ramp + max(cruise, 0.0)

    def states(self, times: Vector) -> tuple[Vector, Vector, Vector]:
        """
        Return the covered distance, speed and acceleration at times (k,) [s].

        At both ends speed and acceleration are 0.
        """
        to_end = self.duration - times
        ramp, rate = self._ramp, self._acceleration
        rising, falling = times <= ramp, to_end < ramp
        place = np.where(
            rising, 0.5 * rate * times**2,
            np.where(falling, self._distance - 0.5 * rate * to_end**2,
                     self._peak * (times - 0.5 * ramp)))
        speed = np.where(rising, rate * times, np.where(falling, rate * to_end, self._peak))
        acceleration = np.where(rising, rate, np.where(falling, -rate, 0.0))
        acceleration[(times <= 0.0) | (to_end <= 0.0)] = 0.0
        return np.clip(place, 0.0, self._distance), np.maximum(speed, 0.0), acceleration


def sample_times(duration: float) -> Iterator[float]:
    """Yield the multiples of :data:`SAMPLING_TIME` before a duration [s], and the duration."""
    for k in range(math.ceil((duration - _SHORTEST_INTERVAL) / SAMPLING_TIME)):
        yield SAMPLING_TIME * k
    yield duration


def point_to_point(start: Vector, end: Vector, limits: MotionLimits) -> QuinticMotion:
    """
    Return a motion in which all joints start, cruise and stop together.

    Every joint has the smallest velocity and the smallest acceleration limit of all.

    :param start: (m,) at rest.
    :param end: (m,) at rest, not equal to the start.
    """
    way = end - start
    distance = float(np.abs(way).max())
    profile = TrapezoidalProfile(
        distance, float(limits.velocity.min()), float(limits.acceleration.min()))
    times = np.array(list(sample_times(profile.duration)))
    place, speed, rate = (values[:, None] / distance for values in profile.states(times))
    return QuinticMotion(times, start + place * way, speed * way, rate * way)
