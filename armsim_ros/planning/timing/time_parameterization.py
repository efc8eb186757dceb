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

from collections.abc import Sequence
from dataclasses import dataclass
import importlib

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.planning.timing.limits import MotionLimits, SpeedLimit
from armsim_ros.quintic_motion import QuinticMotion

MERGE_DISTANCE = 1e-6
"""Waypoints nearer than this [rad or m] are one."""


class BlendedPath:
    """
    Straight segments that a parabola joins at every inner waypoint.

    A blend leaves the incoming segment at a distance d before the corner and meets the outgoing
    one at d behind it: a quadratic Bezier curve with the corner as its control point, known as
    the Hermite blend that keeps the direction at both ends. Path position runs at speed 1 on the
    segments; the first derivative is continuous and, on a blend, linear; the second is constant
    on each piece. So joint velocity and acceleration take their extremes at the ends of a piece.

    :param waypoints: (m, n) m >= 2 different positions [rad or m].
    :param deviation: the largest distance between corner and curve [rad or m]; a number, or one
        for each of the m - 2 inner waypoints.
    """

    def __init__(self, waypoints: Vector, deviation: float | Sequence[float] | Vector) -> None:
        points = np.asarray(waypoints, dtype=np.float64)
        steps = np.diff(points, axis=0)
        lengths = np.linalg.norm(steps, axis=1)
        if len(points) < 2 or not bool(np.all(lengths > 0.0)):
            raise ValueError('a path needs two or more waypoints, neighbours different')
        self.waypoints = points
        self.deviation = np.broadcast_to(np.asarray(deviation, dtype=np.float64),
                                         (len(points) - 2,)).copy()
        directions = steps / lengths[:, None]
        reach = self._blend_reach(directions, lengths)
        starts: list[Vector] = []
        slopes: list[Vector] = []
        curvatures: list[Vector] = []
        spans: list[float] = []
        self.corner_pieces: dict[int, int] = {}
        at = points[0]
        for k in range(len(steps)):
            before = reach[k - 1] if k else 0.0
            after = reach[k] if k < len(reach) else 0.0
            straight = max(lengths[k] - before - after, 0.0)
            if straight > MERGE_DISTANCE or not spans:
                starts.append(at)
                slopes.append(directions[k])
                curvatures.append(np.zeros(points.shape[1]))
                spans.append(straight)
            at = points[k + 1] - after * directions[k]
            if after > 0.0:
                self.corner_pieces[k] = len(spans)
                starts.append(at)
                slopes.append(directions[k])
                curvatures.append((directions[k + 1] - directions[k]) / (2.0 * after))
                spans.append(2.0 * after)
                at = points[k + 1] + after * directions[k + 1]
        self._starts = np.array(starts)
        self._slopes = np.array(slopes)
        self._curvatures = np.array(curvatures)
        self.spans = np.array(spans)
        self.knots = np.concatenate([[0.0], np.cumsum(self.spans)])

    def _blend_reach(self, directions: Vector, lengths: Vector) -> Vector:
        turn = np.linalg.norm(np.diff(directions, axis=0), axis=1)
        wanted = 4.0 * self.deviation / np.maximum(turn, 1e-9)
        limit = 0.5 * np.minimum(lengths[:-1], lengths[1:])
        reach: Vector = np.where(turn < 1e-9, 0.0, np.minimum(wanted, limit))
        return reach

    @property
    def length(self) -> float:
        """Path position of the end [rad or m]."""
        return float(self.knots[-1])

    def piece_at(self, s: Vector) -> NDArray[np.int64]:
        """Return for every path position the piece that holds it, the later piece at a knot."""
        found = np.searchsorted(self.knots, s, side='right') - 1
        return np.clip(found, 0, len(self.spans) - 1)

    def position(self, s: Vector) -> Vector:
        """Return the joint positions (k, n) at path positions s (k,)."""
        piece = self.piece_at(s)
        x = (s - self.knots[piece])[:, None]
        result: Vector = self._starts[piece] + x * (
            self._slopes[piece] + 0.5 * x * self._curvatures[piece])
        return result

    def slope(self, s: Vector, piece: NDArray[np.int64] | None = None) -> Vector:
        """
        Return the first derivative (k, n).

        :param s: (k,) path positions.
        :param piece: (k,) which piece's polynomial to use; by default the piece that holds s.
        """
        which = self.piece_at(s) if piece is None else piece
        x = (s - self.knots[which])[:, None]
        result: Vector = self._slopes[which] + x * self._curvatures[which]
        return result

    def curvature(self, piece: NDArray[np.int64]) -> Vector:
        """Return the second derivative (k, n), which is constant on a piece."""
        result: Vector = self._curvatures[piece]
        return result

    def corner_samples(self, corner: int, count: int) -> Vector:
        """
        Return positions on the blend at an inner waypoint.

        :param corner: 0 for the first inner waypoint.
        :param count: how many, ends included.
        :returns: (count, n); (0, n) where that waypoint has no blend.
        """
        piece = self.corner_pieces.get(corner)
        if piece is None:
            return np.empty((0, self.waypoints.shape[1]))
        return self.position(np.linspace(self.knots[piece], self.knots[piece + 1], count))


POINT_SPACING = (0.025, 0.08)
"""Time between two points [s] of short motions, and the most for long ones."""

POINTS = 400
"""Points of a motion up to which the short spacing holds."""

LONGEST = 3600.0
"""A motion that lasts longer [s] is treated as an error."""

_PANELS = 6
_BLEND_STAGES = 6
_STRAIGHT_STAGES = 6
_MAX_STAGE = 0.2
_MANY_PIECES = 50
_STAGES_OF_MANY = 400
_SOURCE = 'AddTimeOptimalParameterization'


def warm_up() -> None:
    """Import what a first request would wait for (about a second, once)."""
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
            np.searchsorted(self.times, inside, side='right') - 1, 0, len(self.times) - 2)
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
    # Squared speed is linear on a stage, the limit is not: both ends keep the lower limit.
    lower = np.minimum(fastest[:-1], fastest[1:])
    fastest = np.minimum(np.append(lower, np.inf), np.append(np.inf, lower))
    # The solver's tolerances are absolute: it gets the motion at a speed of about 1.
    unit = float(np.max(limits.velocity))
    speed = fastest_path_speed(
        grid, first, last, path.curvature(piece), fastest / unit, limits.acceleration / unit**2)
    if speed is None:
        raise PlanningError(
            MoveItErrorCode.FAILURE,
            'the path cannot be timed within velocity limits '
            f'{np.round(limits.velocity, 4).tolist()} and acceleration limits '
            f'{np.round(limits.acceleration, 4).tolist()}; raise them in joint_limits.yaml '
            'or the scaling factors',
            _SOURCE)
    speed = speed * unit
    mean = 0.5 * (speed[:-1] + speed[1:])
    times = np.concatenate([[0.0], np.cumsum(np.diff(grid) / np.maximum(mean, 1e-9))])
    return _SpeedProfile(grid, speed, times)


def _averaged(
    path: BlendedPath, profile: _SpeedProfile, windows: tuple[float, float], spacing: float
) -> QuinticMotion:
    """Return the motion averaged over a window, and the result over another."""
    first, second = windows
    duration = profile.duration + first + second
    times = np.linspace(0.0, duration, max(2, int(np.ceil(duration / spacing)) + 1))
    weights = np.ones(_PANELS + 1)
    weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
    weights /= weights.sum()
    panels = np.arange(_PANELS + 1)
    # (panels of the second window, of the first) a time before the present.
    if first == second:  # the panels of both meet
        places, before = panels[:, None] + panels, np.arange(2 * _PANELS + 1) * (first / _PANELS)
    else:
        places = panels[:, None] * (_PANELS + 1) + panels
        before = (panels[:, None] * (second / _PANELS) + panels * (first / _PANELS)).ravel()
    past = profile.path_position((times[:, None] - before).ravel())
    found = path.position(past).reshape(len(times), len(before), -1)
    # The average of the positions over the first window, by Simpson's rule.
    average = np.zeros((_PANELS + 1, len(before)))
    average[panels[:, None], places] = weights
    means = average @ found
    positions = weights @ means
    velocities = (means[:, 0] - means[:, -1]) / second
    corners = found[:, places[[0, 0, -1, -1], [0, -1, 0, -1]]]
    accelerations = (corners[:, 0] - corners[:, 1] - corners[:, 2] + corners[:, 3]) / (
        first * second)
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
    :param speed_limit: of the path, e.g. for a limit of a link's speed.
    :returns: points at most 0.1 s apart.
    :raises PlanningError: FAILURE where no speed keeps the limits.
    """
    profile = _speed_profile(path, limits, speed_limit)
    if profile.duration > LONGEST:
        raise PlanningError(
            MoveItErrorCode.FAILURE,
            f'the motion would last {profile.duration:.0f} s, more than {LONGEST:.0f} s; raise '
            'the scaling factors or the limits', _SOURCE)
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
        float(np.sqrt(np.max(acceleration / limits.acceleration))))
