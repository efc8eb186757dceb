# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of the timing of paths."""

from itertools import pairwise
import logging
import math

import numpy as np
import pytest

from armsim_ros.errors import PlanningError
from armsim_ros.planning.timing.limits import MotionLimits, scaling_factor
from armsim_ros.planning.timing.time_parameterization import BlendedPath, time_path


def limits(n=4, velocity=2.0, acceleration=5.0, jerk=math.inf):
    """Return equal limits for n joints."""
    return MotionLimits(np.full(n, velocity), np.full(n, acceleration), np.full(n, jerk))


@pytest.fixture
def zigzag():
    """Seven waypoints of four joints that turn sharply."""
    return np.random.default_rng(7).uniform(-1.5, 1.5, (7, 4))


def distance_to_polyline(points, waypoints):
    """Return the largest distance of points to a polyline, segment by segment."""
    best = np.full(len(points), np.inf)
    for a, b in pairwise(waypoints):
        along = np.clip((points - a) @ (b - a) / np.dot(b - a, b - a), 0.0, 1.0)
        best = np.minimum(best, np.linalg.norm(points - a - along[:, None] * (b - a), axis=1))
    return best.max()


def test_limits_hold_at_every_point(zigzag):
    """ADP-6: velocity and acceleration of every point are within their limits."""
    motion = time_path(BlendedPath(zigzag, 0.05), limits())
    assert np.abs(motion.velocities).max() <= 2.0 * 1.001
    assert np.abs(motion.accelerations).max() <= 5.0 * 1.001


def test_limits_hold_between_points(zigzag):
    """ADP-7: finite differences of the interpolated motion keep the limits too."""
    motion = time_path(BlendedPath(zigzag, 0.05), limits())
    times, step = np.linspace(0.0, motion.duration, 20001, retstep=True)
    positions = motion.sample(times)
    velocity = np.diff(positions, axis=0) / step
    acceleration = np.diff(velocity, axis=0) / step
    assert np.abs(velocity).max() <= 2.0 * 1.002
    assert np.abs(acceleration).max() <= 5.0 * 1.01


def test_limits_hold_at_the_peaks(zigzag):
    """The extremes of velocity and acceleration between the points exceed no limit."""
    velocity, acceleration = time_path(BlendedPath(zigzag, 0.05), limits()).peaks()
    assert velocity.max() <= 2.0 * (1.0 + 1e-9)
    assert acceleration.max() <= 5.0 * (1.0 + 1e-9)


def test_the_motion_is_not_much_slower_than_the_limits_allow(zigzag):
    """Some joint is at one of its limits for most of the time."""
    motion = time_path(BlendedPath(zigzag, 0.05), limits())
    busy = np.maximum(
        np.abs(motion.velocities).max(axis=1) / 2.0,
        np.abs(motion.accelerations).max(axis=1) / 5.0,
    )
    assert np.median(busy) > 0.9


def test_straight_motion_takes_the_time_of_a_trapezoid():
    """A straight segment lasts as long as a trapezoidal profile, and the averaging window."""
    motion = time_path(BlendedPath(np.array([[0.0], [3.0]]), 0.0), limits(1))
    assert motion.duration == pytest.approx(3.0 / 2.0 + 2.0 / 5.0 + 0.05, rel=0.02)


def test_rest_at_both_ends(zigzag):
    """REQ-17: velocity and acceleration are 0 in the first and the last point."""
    motion = time_path(BlendedPath(zigzag, 0.05), limits())
    for values in (motion.velocities, motion.accelerations):
        assert np.all(values[[0, -1]] == 0.0)


def test_ends_are_exact(zigzag):
    """REQ-17: first and last point are the first and last waypoint, time begins at 0."""
    motion = time_path(BlendedPath(zigzag, 0.05), limits())
    assert motion.times[0] == 0.0
    assert np.array_equal(motion.positions[[0, -1]], zigzag[[0, -1]])


def test_points_are_close_and_in_order(zigzag):
    """ADP-7: times increase by no more than 0.1 s."""
    steps = np.diff(time_path(BlendedPath(zigzag, 0.05), limits(acceleration=0.3)).times)
    assert steps.min() > 0.0
    assert steps.max() <= 0.1


def test_the_path_is_not_left(zigzag):
    """ADP-7: the interpolated motion stays within the blends' deviation from the polyline."""
    motion = time_path(BlendedPath(zigzag, 0.03), limits())
    samples = motion.sample(np.linspace(0.0, motion.duration, 5000))
    assert distance_to_polyline(samples, zigzag) < 0.03 + 0.002


def test_a_small_deviation_stays_at_the_corners(zigzag):
    """With a deviation near 0 the motion runs to every corner."""
    motion = time_path(BlendedPath(zigzag, 1e-4), limits())
    samples = motion.sample(np.linspace(0.0, motion.duration, 5000))
    assert distance_to_polyline(samples, zigzag) < 0.001


def test_jerk_limit_is_kept(zigzag):
    """A jerk limit bounds the change of acceleration between the points."""
    motion = time_path(BlendedPath(zigzag, 0.05), limits(jerk=50.0))
    jerk = np.diff(motion.accelerations, axis=0) / np.diff(motion.times)[:, None]
    assert np.abs(jerk).max() <= 50.0 * 1.01


def test_speed_limit_along_the_path(zigzag):
    """REQ-12: a limit on path speed is kept; here the norm of joint velocity."""
    def at_most_half(positions, slopes):
        return 0.5 / np.maximum(np.linalg.norm(slopes, axis=1), 1e-6)

    motion = time_path(BlendedPath(zigzag, 0.05), limits(), at_most_half)
    assert np.linalg.norm(motion.velocities, axis=1).max() <= 0.5 * 1.001


def test_same_path_same_times(zigzag):
    """ADP-6: the duration is repeatable to the last bit."""
    first, second = (time_path(BlendedPath(zigzag, 0.05), limits()) for _ in range(2))
    assert np.array_equal(first.times, second.times)
    assert np.array_equal(first.positions, second.positions)


def test_a_turn_back_on_itself():
    """UT-11: a path that returns on itself stops at its turn and stays on the line."""
    waypoints = np.array([[0.0, 0.0], [1.0, 0.5], [0.2, 0.1]])
    motion = time_path(BlendedPath(waypoints, 0.01), limits(2))
    samples = motion.sample(np.linspace(0.0, motion.duration, 3000))
    assert distance_to_polyline(samples, waypoints) < 1e-3
    assert samples[:, 0].max() > 0.98


def test_a_path_needs_different_neighbours():
    """Two equal waypoints in a row are refused."""
    with pytest.raises(ValueError, match='different'):
        BlendedPath(np.zeros((2, 3)), 0.1)


def test_slow_motions_have_no_more_points_than_needed(zigzag):
    """ADP-7: a long motion has points up to 0.1 s apart, and keeps its limits."""
    motion = time_path(BlendedPath(zigzag, 0.05), limits(velocity=0.05))
    assert motion.duration > 100.0
    steps = np.diff(motion.times)
    assert 0.07 < steps.max() <= 0.1
    assert np.abs(motion.velocities).max() <= 0.05 * 1.001


def test_a_motion_that_never_ends_is_refused(zigzag):
    """A motion of hours is taken for a mistake in the scaling factors."""
    with pytest.raises(PlanningError, match='scaling factors'):
        time_path(BlendedPath(zigzag, 0.05), limits(velocity=1e-4))


@pytest.mark.parametrize('factor', [1e-300, 1e-12])
def test_tiny_scaling_factors_are_numbers_to_divide_by(factor):
    """REQ-6: no scaling factor makes the timing overflow."""
    log = logging.getLogger('tiny')
    limits = MotionLimits(np.ones(2), np.ones(2), np.full(2, np.inf))
    scaled = limits.scaled(scaling_factor(factor, 'velocity', log), 1.0)
    with np.errstate(all='raise'):
        assert np.all(np.isfinite(1.0 / scaled.velocity**2))
