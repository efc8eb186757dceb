# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Motions that bring moving joints to rest."""

from __future__ import annotations

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.control.trajectory.sampling import Motion, spline_coefficients, with_effort
from armsim_ros.quintic_motion import DEGREE, QUINTIC, with_derivatives


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
