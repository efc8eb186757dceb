# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The points that a stream sends to a trajectory controller."""

import numpy as np

from armsim_ros.planning.servo.trajectory_window import TrajectoryWindow

PERIOD, LATENCY, START = 10_000_000, 100_000_000, 1_000_000_000


def filled(*positions):
    """Return a window that began at 0 and got positions, one a period."""
    window = TrajectoryWindow(LATENCY)
    window.start(START, np.zeros(1))
    for k, position in enumerate(positions):
        window.add(START + k * PERIOD, np.array([position]))
    return window


def test_the_first_command_goes_out_at_once():
    """The first message leads from rest to the first command; before it there is none."""
    assert filled().points() is None
    points = filled(0.1).points()
    np.testing.assert_allclose(points.times, [0.0, 0.1])
    np.testing.assert_allclose(points.positions[:, 0], [0.0, 0.1])
    assert not points.velocities.any()
    np.testing.assert_allclose(filled(0.1, 0.2).points().times, [0.0, 0.1])


def test_all_but_the_newest_from_the_first_stamp():
    """The stamp is that of the first point, the newest point is kept back."""
    points = filled(0.1, 0.2, 0.3).points()
    assert points.stamp_ns == START
    np.testing.assert_allclose(points.times, [0.0, 0.1, 0.11])
    np.testing.assert_allclose(points.positions[:, 0], [0.0, 0.1, 0.2])


def test_velocities():
    """A velocity is the smaller difference, 0 where the motion turns and at the end."""
    points = filled(0.1, 0.11, 0.13, 0.12, 0.11, 0.10).points()
    np.testing.assert_allclose(points.velocities[:, 0], [0.0, 1.0, 1.0, 0.0, -1.0, 0.0])


def test_the_past_is_forgotten():
    """Of what lies behind only the last point stays, besides what may still be on its way."""
    window = filled(*np.linspace(0.0, 1.0, 100))
    points = window.points()
    now = START + 99 * PERIOD
    assert now - 4 * PERIOD <= points.stamp_ns <= now
    assert points.stamp_ns + round(points.times[-1] * 1e9) == now + LATENCY - PERIOD
