# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From free waypoints to a timed motion that was checked as a controller will run it."""

from __future__ import annotations

from itertools import pairwise
import math

import numpy as np
from numpy.typing import NDArray

from armsim_ros.errors import PlanningError
from armsim_ros.planning.blended_path import BlendedPath
from armsim_ros.planning.error_codes import MoveItErrorCode
from armsim_ros.planning.limits import MotionLimits
from armsim_ros.planning.quintic import QuinticMotion
from armsim_ros.planning.state_validity import StateValidity
from armsim_ros.planning.time_parameterization import SpeedLimit, time_path

Vector = NDArray[np.float64]

MAX_DEVIATION = 0.05
"""Largest distance [rad or m] in joint space between a corner and the blend that rounds it."""

FINAL_SHARE = 0.6
"""The last check's step as a share of that of the path's."""

_LEAST_DEVIATION = 1e-4
_SHRINK = 0.35
_ATTEMPTS = 4
_LOOKS = 5
_FINER = 16
_MOST_CLOSE = 6000
_OVERSHOOT = 1e-3


def time_waypoints(
    waypoints: Vector, validity: StateValidity, limits: MotionLimits,
    speed_limit: SpeedLimit | None, step: float, max_deviation: float = MAX_DEVIATION,
) -> QuinticMotion:
    """
    Return the fastest motion through free waypoints that is free itself.

    Every blend shrinks until it is free; where the timed motion is not free yet, all shrink.

    :param waypoints: (k, m) k >= 2.
    :param step: largest motion of any point between two checks [m].
    :param max_deviation: of a blend from its corner [rad or m].
    :raises PlanningError: INVALID_MOTION_PLAN with time and cause where it stays blocked;
        FAILURE where the limits cannot be kept.
    """
    deviation = np.full(len(waypoints) - 2, max_deviation)
    _shrink_corners(waypoints, deviation, validity, step)
    cause = ''
    for _ in range(_ATTEMPTS):
        motion = time_path(BlendedPath(waypoints, deviation), limits, speed_limit)
        cause = first_fault(motion, validity, FINAL_SHARE * step)
        if not cause:
            return motion
        if not len(deviation):
            break
        deviation = np.maximum(deviation * _SHRINK**2, _LEAST_DEVIATION)
    raise PlanningError(
        MoveItErrorCode.INVALID_MOTION_PLAN,
        f'the timed trajectory is not valid {cause}; plan again, or keep more room around '
        'objects',
        'ValidateSolution',
    )


def _shrink_corners(
    waypoints: Vector, deviation: Vector, validity: StateValidity, step: float
) -> None:
    """Make the blend at every inner waypoint so small that it is free."""
    for corner in range(len(deviation)):
        three = waypoints[corner:corner + 3]
        while deviation[corner] > _LEAST_DEVIATION:
            blend = BlendedPath(three, float(deviation[corner])).corner_samples(0, 9)
            if all(validity.motion_free(a, b, step) for a, b in pairwise(blend)):
                break
            deviation[corner] = max(deviation[corner] * _SHRINK, _LEAST_DEVIATION)


def first_fault(motion: QuinticMotion, validity: StateValidity, step: float) -> str:
    """
    Return when and why a motion leaves the free states, as a phrase; '' for never.

    Where anything comes near, the step is many times smaller, so that not even a corner is
    grazed.

    :param motion: is followed between its points too.
    :param step: largest motion of any point between two checks [m].
    """
    times = np.linspace(0.0, motion.duration, _LOOKS * len(motion.times))
    positions = motion.sample(times)
    beyond = np.flatnonzero(np.any(
        (positions < validity.lower - _OVERSHOOT) | (positions > validity.upper + _OVERSHOOT),
        axis=1,
    ))
    if len(beyond):
        return _fault(float(times[beyond[0]]), positions[beyond[0]], validity)
    moved = np.abs(np.diff(positions, axis=0)) @ validity.levers
    covered = np.concatenate([[0.0], np.cumsum(moved)])
    places = np.linspace(0.0, covered[-1], 2 + math.ceil(float(covered[-1]) / step))
    looked = np.interp(places, covered, times)
    close = []
    for k, (t, values) in enumerate(zip(looked, motion.sample(looked), strict=True)):
        if not validity.clear(values):
            if not validity.free(values):
                return _fault(float(t), values, validity)
            close.append(k)
    return _closer_look(motion, validity, np.interp(
        _between(places, close), covered, times
    ))


def _between(places: Vector, close: list[int]) -> Vector:
    """Return finer places on both sides of those where something is close."""
    parts = max(2, min(_FINER, _MOST_CLOSE // max(1, len(close))))
    gaps = sorted({gap for k in close for gap in (k - 1, k) if 0 <= gap < len(places) - 1})
    inner = np.arange(1, parts) / parts
    finer: Vector = np.concatenate(
        [places[gap] + inner * (places[gap + 1] - places[gap]) for gap in gaps] or [places[:0]]
    )
    return finer


def _closer_look(motion: QuinticMotion, validity: StateValidity, times: Vector) -> str:
    for t, values in zip(times, motion.sample(times), strict=True):
        if not validity.free(values):
            return _fault(float(t), values, validity)
    return ''


def _fault(t: float, values: Vector, validity: StateValidity) -> str:
    return f'at {t:.3f} s: {validity.why_not(values)}'
