# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Motions that bring moving joints to rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsim_ros.control import segments
from armsim_ros.control.sampling import Motion

Vector = NDArray[np.float64]


def deceleration(
    position: Vector, velocity: Vector, maximum: Vector, *, effort: bool = False
) -> Motion:
    """
    Brake every joint with its own constant deceleration.

    A joint with velocity v comes to rest after |v| / a and v^2 / (2 a) further on.

    :param position: (n,) [rad or m].
    :param velocity: (n,) [rad/s or m/s].
    :param maximum: (n,) positive decelerations [rad/s^2 or m/s^2].
    """
    durations = np.abs(velocity) / maximum
    rest = position + velocity * durations / 2.0
    joints = len(position)
    final = np.zeros(joints * (4 if effort else 3))
    final[:joints] = rest
    ends = np.unique(durations[durations > 1e-9])
    if not len(ends):
        return Motion.standing(final)
    begins = np.concatenate(([0.0], ends[:-1]))
    T = (ends - begins)[:, None]
    brakes = durations > begins[:, None] + 1e-12
    remaining = np.where(brakes, durations - begins[:, None], 0.0)
    a = -np.sign(velocity) * maximum
    c = np.zeros((len(ends), segments.DEGREE + 1, joints))
    c[:, 0] = rest + 0.5 * a * remaining**2
    c[:, 1] = -a * remaining * T
    c[:, 2] = np.where(brakes, 0.5 * a * T**2, 0.0)
    full = segments.with_derivatives(c, ends - begins)
    if effort:
        full = segments.with_effort(full, *np.zeros((2, len(ends), joints)))
    return Motion(0.0, ends.tolist(), full, final)


def stop_ramp(
    position: Vector, velocity: Vector, duration: float, *, effort: bool = False
) -> Motion:
    """
    Come to rest on a quintic within a time, as ``stop_trajectory_duration`` of ROS 1 asks.

    The resting position is the middle of the quintic that turns velocity v into -v within twice
    the duration D; it lies 0.625 * v * D further on.

    :param position: (n,) of the reference [rad or m].
    :param velocity: (n,) of the reference [rad/s or m/s].
    :param duration: D, positive [s].
    """
    zero = np.zeros_like(position)
    there = np.stack((position, velocity, zero))[:, None]
    back = np.stack((position, -velocity, zero))[:, None]
    quintic = np.array([segments.QUINTIC])
    turning = segments.spline_coefficients(np.array([2.0 * duration]), quintic, there, back)
    middle = 0.5 ** np.arange(segments.DEGREE + 1) @ turning[0]
    rest = np.stack((middle[: len(position)], zero, zero))[:, None]
    ramp = segments.spline_coefficients(np.array([duration]), quintic, there, rest)
    final = np.zeros(len(position) * (4 if effort else 3))
    final[: len(position)] = rest[0, 0]
    if effort:
        ramp = segments.with_effort(ramp, zero[None], zero[None])
    return Motion(0.0, [duration], ramp, final)
