# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
When a path is where: the fastest motion along it that keeps the limits.

TOPP-RA (Pham and Pham 2018, DOI 10.1109/TRO.2018.2819195) gives path speed over path position.
Two moving averages over time then round the steps in acceleration: an average of motions that
keep the limits keeps them too, starts and ends at rest, and its jerk is at most
2 * acceleration limit / window (Biagiotti and Melchiorri 2012,
DOI 10.1016/j.automatica.2011.11.016). Each leaves the path by at most
acceleration limit * window^2 / 24, and not at all on straight pieces. What splines between the
points add to velocity and acceleration is taken away again by a slightly slower motion.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
import importlib

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.planning.timing.blended_path import BlendedPath
from armsim_ros.planning.timing.limits import MotionLimits
from armsim_ros.planning.timing.quintic import QuinticMotion

SpeedLimit = Callable[[Vector, Vector], Vector]

POINT_SPACING = (0.025, 0.08)
"""Time between two points [s] of short motions, and the most for long ones."""

POINTS = 400
"""Points of a motion up to which the short spacing holds."""

LONGEST = 3600.0
"""A motion that lasts longer [s] is taken for a mistake."""

_PANELS = 6
_BLEND_STAGES = 6
_STRAIGHT_STAGES = 6
_MAX_STAGE = 0.2
_MANY_PIECES = 50
_STAGES_OF_MANY = 400
_SOURCE = 'AddTimeOptimalParameterization'


def warm_up() -> None:
    """Import what a first request would wait for (about one second, once)."""
    importlib.import_module('armsim_ros.planning.timing.topp')


@dataclass(frozen=True, slots=True, eq=False)
class _SpeedProfile:
    """Path position over time, quadratic in every stage."""

    grid: Vector
    speed: Vector
    times: Vector

    @property
    def duration(self) -> float:
        return float(self.times[-1])

    def path_position(self, t: Vector) -> Vector:
        """Return the path position at times t (k,)."""
        inside = np.clip(t, 0.0, self.duration)
        stage = np.clip(
            np.searchsorted(self.times, inside, side='right') - 1, 0, len(self.times) - 2
        )
        after = inside - self.times[stage]
        span = self.times[stage + 1] - self.times[stage]
        rate = (self.speed[stage + 1] - self.speed[stage]) / span
        s: Vector = self.grid[stage] + after * (self.speed[stage] + 0.5 * after * rate)
        return s


def _grid(path: BlendedPath) -> tuple[Vector, NDArray[np.int64]]:
    """Return the stages' borders, all knots among them, and the piece of each stage."""
    straight = ~np.any(path.curvature(np.arange(len(path.spans))), axis=1)
    longest = _MAX_STAGE
    least = np.where(straight, _STRAIGHT_STAGES, _BLEND_STAGES)
    if len(path.spans) > _MANY_PIECES:
        longest = min(longest, path.length / _STAGES_OF_MANY)
        least = np.where(straight, 1, 2)
    counts = np.maximum(least, np.ceil(path.spans / longest)).astype(np.int64)
    pieces = np.repeat(np.arange(len(counts)), counts)
    ends = np.cumsum(counts)
    number = 1 + np.arange(len(pieces)) - (ends - counts)[pieces]
    borders = path.knots[pieces] + number / counts[pieces] * path.spans[pieces]
    borders[ends - 1] = path.knots[1:]
    return np.concatenate([[0.0], borders]), pieces


def _speed_profile(
    path: BlendedPath, limits: MotionLimits, speed_limit: SpeedLimit | None
) -> _SpeedProfile:
    from armsim_ros.planning.timing.topp import fastest_path_speed

    grid, piece = _grid(path)
    first, last = path.slope(grid[:-1], piece), path.slope(grid[1:], piece)
    ends = np.concatenate([first, last[-1:]])
    with np.errstate(divide='ignore'):
        fastest = np.min(limits.velocity / np.abs(ends), axis=1)
    if speed_limit is not None:
        fastest = np.minimum(fastest, speed_limit(path.position(grid), ends))
    # Squared speed is linear on a stage, the limit is not: both ends keep the lower one.
    lower = np.minimum(fastest[:-1], fastest[1:])
    fastest = np.minimum(np.append(lower, np.inf), np.append(np.inf, lower))
    # The solver's tolerances are absolute: it gets the motion at a speed of about 1.
    unit = float(np.max(limits.velocity))
    speed = fastest_path_speed(
        grid, first, last, path.curvature(piece), fastest / unit, limits.acceleration / unit**2
    )
    if speed is None:
        raise PlanningError(
            MoveItErrorCode.FAILURE,
            'the path cannot be timed within velocity limits '
            f'{np.round(limits.velocity, 4).tolist()} and acceleration limits '
            f'{np.round(limits.acceleration, 4).tolist()}; raise them in joint_limits.yaml '
            'or the scaling factors',
            _SOURCE,
        )
    speed = speed * unit
    mean = 0.5 * (speed[:-1] + speed[1:])
    times = np.concatenate([[0.0], np.cumsum(np.diff(grid) / np.maximum(mean, 1e-9))])
    return _SpeedProfile(grid, speed, times)


def _averaged(
    path: BlendedPath, profile: _SpeedProfile, windows: tuple[float, float], spacing: float
) -> QuinticMotion:
    """Return the motion averaged over one window, and the result over another."""
    first, second = windows
    duration = profile.duration + first + second
    times = np.linspace(0.0, duration, max(2, int(np.ceil(duration / spacing)) + 1))
    weights = np.ones(_PANELS + 1)
    weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
    weights /= weights.sum()

    def position(t: Vector) -> Vector:
        return path.position(profile.path_position(t))

    def mean(t: Vector) -> Vector:
        """Return the average of the positions from t - first to t, by Simpson's rule."""
        around = (t[:, None] - np.linspace(0.0, first, _PANELS + 1)).ravel()
        values: Vector = np.einsum(
            'w,twn->tn', weights, position(around).reshape(len(t), _PANELS + 1, -1)
        )
        return values

    around = times[:, None] - np.linspace(0.0, second, _PANELS + 1)
    means = mean(around.ravel()).reshape(len(times), _PANELS + 1, -1)
    positions = np.einsum('w,twn->tn', weights, means)
    velocities = (means[:, 0] - means[:, -1]) / second
    accelerations = (
        position(times) - position(times - first) - position(times - second)
        + position(times - first - second)
    ) / (first * second)
    velocities[[0, -1]] = 0.0
    accelerations[[0, -1]] = 0.0
    positions[0], positions[-1] = path.waypoints[0], path.waypoints[-1]
    return QuinticMotion(times, positions, velocities, accelerations)


def time_path(
    path: BlendedPath, limits: MotionLimits, speed_limit: SpeedLimit | None = None
) -> QuinticMotion:
    """
    Return the fastest motion along a path, from rest to rest.

    :param path: what to follow.
    :param limits: kept by the motion between the points as well, as a controller with quintic
        interpolation runs it.
    :param speed_limit: (positions (k, n), slopes (k, n)) -> (k,) largest path speed, e.g. for a
        limit of a link's speed.
    :returns: points at most 0.1 s apart.
    :raises PlanningError: FAILURE where no speed keeps the limits.
    """
    profile = _speed_profile(path, limits, speed_limit)
    if profile.duration > LONGEST:
        raise PlanningError(
            MoveItErrorCode.FAILURE,
            f'the motion would last {profile.duration:.0f} s, more than {LONGEST:.0f} s; raise '
            'the scaling factors or the limits', _SOURCE,
        )
    spacing = min(max(profile.duration / POINTS, POINT_SPACING[0]), POINT_SPACING[1])
    jerk_window = float(np.max(2.0 * limits.acceleration / limits.jerk))
    motion = _averaged(path, profile, (max(spacing, jerk_window), spacing), spacing)
    too_fast = _excess(motion, limits)
    return motion.slowed(too_fast) if too_fast > 1.0 else motion


def _excess(motion: QuinticMotion, limits: MotionLimits) -> float:
    """Return by which factor a motion has to be slower to keep the limits."""
    velocity, acceleration = motion.peaks()
    return max(
        float(np.max(velocity / limits.velocity)),
        float(np.sqrt(np.max(acceleration / limits.acceleration))),
    )
