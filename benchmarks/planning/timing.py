# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Timing of random paths: processor time, distance from the path, limits, duration."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from statistics import median
import time

import numpy as np
from toppra import algorithm, constraint, SplineInterpolator

from armsim_ros.planning.timing.limits import MotionLimits
from armsim_ros.planning.timing.path_timing import MAX_DEVIATION
from armsim_ros.planning.timing.time_parameterization import BlendedPath, time_path
from benchmarks.options import Options
from benchmarks.planning.problems import ACCELERATION, VELOCITY

WAYPOINTS, JOINTS, SAMPLES = 10, 6, 20000

Motion = tuple[float, Callable[[np.ndarray], np.ndarray]]


def ours(path: np.ndarray) -> Motion:
    """Blend the corners, time with the grid split at the knots, smooth."""
    limits = MotionLimits(
        np.full(JOINTS, VELOCITY), np.full(JOINTS, ACCELERATION), np.full(JOINTS, np.inf))
    motion = time_path(BlendedPath(path, MAX_DEVIATION), limits)
    return motion.duration, motion.sample


def toppra(parametrizer: str) -> Callable[[np.ndarray], Motion]:
    """Return toppra on a cubic spline through the waypoints."""
    def timed(path: np.ndarray) -> Motion:
        places = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
        limits = [np.full(JOINTS, value) for value in (VELOCITY, ACCELERATION)]
        motion = algorithm.TOPPRA(
            [constraint.JointVelocityConstraint(np.stack([-limits[0], limits[0]], axis=1)),
             constraint.JointAccelerationConstraint(np.stack([-limits[1], limits[1]], axis=1))],
            SplineInterpolator(places, path), parametrizer=parametrizer).compute_trajectory()
        return motion.duration, motion
    return timed


def main(options: Options) -> None:
    """Print a table."""
    ways = {
        'armsim_ros': ours,
        'toppra, ParametrizeConstAccel': toppra('ParametrizeConstAccel'),
        'toppra, ParametrizeSpline': toppra('ParametrizeSpline'),
    }
    generator = np.random.default_rng(options.seed)
    paths = [generator.uniform(-1.5, 1.5, (WAYPOINTS, JOINTS)) for _ in range(options.runs)]
    found: dict[str, list[tuple[float, ...]]] = {name: [] for name in ways}
    for path in paths:
        for name, way in ways.items():
            began = time.process_time()
            duration, sample = way(path)
            spent = 1000.0 * (time.process_time() - began)
            times = np.linspace(0.0, duration, SAMPLES)
            positions = sample(times)
            step = times[1]
            speed = np.diff(positions, axis=0) / step
            rate = np.diff(speed, axis=0) / step
            found[name].append((
                spent, _deviation(positions, path), np.abs(speed).max() / VELOCITY,
                np.quantile(np.abs(rate).max(axis=1), 0.999) / ACCELERATION, duration))
    print(f'{"":>30} {"CPU ms":>8} {"off path rad":>13} {"velocity":>9} {"accel.":>7} '
          f'{"lasts s":>8}')
    for name, rows in found.items():
        columns = list(zip(*rows, strict=True))
        print(f'{name:>30} {median(columns[0]):>8.1f} {max(columns[1]):>13.3f} '
              f'{max(columns[2]):>9.3f} {max(columns[3]):>7.3f} {median(columns[4]):>8.2f}')
    print('velocity and acceleration: the largest of all, as a share of the limit')


def _deviation(positions: np.ndarray, path: np.ndarray) -> float:
    """Return the largest distance of positions from a polyline [rad]."""
    nearest = np.full(len(positions), np.inf)
    for a, b in pairwise(path):
        along = np.clip((positions - a) @ (b - a) / float((b - a) @ (b - a)), 0.0, 1.0)
        away = positions - (a + along[:, None] * (b - a))
        nearest = np.minimum(nearest, np.linalg.norm(away, axis=1))
    return float(nearest.max())
