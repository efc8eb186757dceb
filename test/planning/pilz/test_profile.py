# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The trapezoidal speed profile and its samples."""

from __future__ import annotations

import numpy as np
import pytest

from armsim_ros.planning.pilz.joint_sampling import sample_times, TrapezoidalProfile


@pytest.mark.parametrize('distance', [2.0, 0.1, 1e-4])
def test_profile_keeps_its_limits_and_arrives(distance: float) -> None:
    """
    From 0 to the distance within speed and acceleration, with a cruise only where it fits.

    pilz, velocity_profile_atrap.cpp, SetProfile.
    """
    profile = TrapezoidalProfile(distance, 0.5, 1.0)
    times = np.linspace(0.0, profile.duration, 501)
    place, speed, rate = profile.states(times)
    assert (place[0], place[-1]) == pytest.approx((0.0, distance), abs=1e-12)
    assert speed.max() == pytest.approx(min(0.5, distance**0.5), rel=5e-3)
    assert (rate.max(), rate.min()) == (1.0, -1.0)
    assert np.gradient(place, times)[2:-2] == pytest.approx(speed[2:-2], abs=6e-3)
    assert profile.duration == pytest.approx(
        distance / 0.5 + 0.5 if distance >= 0.25 else 2.0 * distance**0.5)


def test_no_distance_takes_no_time() -> None:
    """
    A profile over nothing is at its end.

    pilz, velocity_profile_atrap.cpp, setEmptyProfile.
    """
    profile = TrapezoidalProfile(0.0, 0.5, 1.0)
    assert profile.duration == 0.0
    assert [each.tolist() for each in profile.states(np.zeros(1))] == [[0.0]] * 3


@pytest.mark.parametrize(('duration', 'expected'), [
    (0.25, [0.0, 0.1, 0.2, 0.25]), (0.3, [0.0, 0.1, 0.2, 0.3]),
    (0.300005, [0.0, 0.1, 0.2, 0.300005]), (0.05, [0.0, 0.05]), (0.0, [0.0]),
])
def test_samples(duration: float, expected: list[float]) -> None:
    """
    Every 0.1 s, and the end once.

    pilz, trajectory_functions.cpp, generateJointTrajectory.
    """
    assert list(sample_times(duration)) == pytest.approx(expected)
