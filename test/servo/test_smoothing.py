# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Filters: no overshoot, no drift, all bounds kept."""

import numpy as np
import pytest

from armsim_ros.servo.smoothing import AccelerationFilter, ButterworthFilter, JerkFilter

PERIOD = 0.01


def limited(jerk=np.inf):
    """Return a filter of two joints."""
    bounds = np.array([1.0, 2.0]), np.array([5.0, 5.0])
    if np.isfinite(jerk):
        return JerkFilter(*bounds, np.full(2, jerk), PERIOD)
    return AccelerationFilter(*bounds, PERIOD)


FILTERS = {
    'butterworth': lambda: ButterworthFilter(1.5),
    'acceleration': limited,
    'jerk': lambda: limited(100.0),
}


@pytest.mark.parametrize('kind', list(FILTERS))
def test_rest_is_rest(kind):
    """What does not move is passed on as it is."""
    made = FILTERS[kind]()
    made.restart(np.array([0.3, -0.2]))
    for _ in range(50):
        output = made.smooth(np.array([0.3, -0.2]))
    np.testing.assert_array_equal(output, [0.3, -0.2])


@pytest.mark.parametrize('kind', list(FILTERS))
def test_a_step_is_reached(kind):
    """A step of the input is reached, at most a hundredth past it."""
    made = FILTERS[kind]()
    made.restart(np.zeros(2))
    outputs = np.array([made.smooth(np.array([0.5, -0.5])) for _ in range(300)])
    np.testing.assert_allclose(outputs[-1], [0.5, -0.5], atol=1e-3)
    assert np.abs(outputs).max() < 0.51


@pytest.mark.parametrize('jerk', [np.inf, 100.0])
def test_bounds(jerk):
    """Velocity, acceleration and jerk stay within their bounds on any input."""
    made = limited(jerk)
    made.restart(np.zeros(2))
    random = np.random.default_rng(5)
    target, outputs = np.zeros(2), [np.zeros(2)] * 3
    for k in range(600):
        if k % 20 == 0:
            target = random.uniform(-0.5, 0.5, 2)
        outputs.append(made.smooth(target))
    velocity = np.diff(outputs, axis=0) / PERIOD
    acceleration = np.diff(velocity, axis=0) / PERIOD
    assert (np.abs(acceleration) <= 5.0 + 1e-6).all()
    if np.isfinite(jerk):
        assert (np.abs(np.diff(acceleration, axis=0)) / PERIOD <= jerk + 1e-6).all()


def test_butterworth_arrives():
    """Where the input rests the output rests soon after, and comes no faster for that."""
    made = ButterworthFilter(1.5)
    made.restart(np.zeros(1))
    ramp = [*np.arange(1, 21) * 2e-3, *[0.04] * 5]
    outputs = np.array([made.smooth(np.array([value]))[0] for value in ramp])
    assert (outputs[23:] == 0.04).all()
    assert np.diff(outputs).max() <= 2e-3 + 1e-12
    assert np.diff(outputs).min() >= 0.0


def test_butterworth_is_the_formula():
    """The output is (x0 + x1 - (1 - k) y1) / (1 + k)."""
    made = ButterworthFilter(2.0)
    made.restart(np.array([1.0]))
    x, y = 1.0, 1.0
    for value in (1.2, 1.5, 1.1):
        y = (value + x + y) / 3.0
        x = value
        assert made.smooth(np.array([value]))[0] == pytest.approx(y)


def test_what_keeps_the_bounds_is_passed_on_without_a_lag():
    """
    A motion that speeds up and brakes within the acceleration limit comes out as it went in.

    Upstream: acceleration_filter.cpp, doSmoothing.
    """
    made = limited()
    made.restart(np.zeros(2))
    velocities = np.array([*np.arange(0.0, 1.0, 0.05), *[1.0] * 50, *np.arange(1.0, -1.0, -0.05)])
    inputs = np.cumsum(velocities * PERIOD)[:, None] * [1.0, -1.0]
    outputs = np.array([made.smooth(each) for each in inputs])
    np.testing.assert_allclose(outputs, inputs, atol=1e-12)
