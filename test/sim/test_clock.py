# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Simulated time."""

import pytest

from armsim_ros.sim.clock import SimClock

STEP = 1_000_000


def test_starts_at_zero_by_itself():
    """Deterministic time starts at 0 and only steps move it."""
    clock = SimClock(STEP)
    assert clock.now_ns == 0
    clock.advance()
    clock.advance()
    assert clock.now_ns == 2 * STEP


def test_starts_at_the_wall_clock_s_time_where_told():
    """Real time starts at the time that was given, and says how far it is behind later."""
    wall = 1_700_000_000_123_456_789
    clock = SimClock(STEP, wall)
    assert clock.now_ns == wall
    clock.advance()
    assert clock.behind_ns(wall + 5 * STEP) == 4 * STEP


def test_the_factor_stretches_the_wall_time_of_a_step():
    """At factor 0.5 a step takes twice its time."""
    clock = SimClock(STEP)
    clock.real_time_factor = 0.5
    assert clock.wall_step_ns == 2 * STEP


@pytest.mark.parametrize('factor', [0.05, 101.0, -1.0, float('nan'), float('inf')])
def test_refuses_a_factor_that_is_none(factor):
    """Only positive, finite factors are taken."""
    clock = SimClock(STEP)
    with pytest.raises(ValueError, match='real time factor'):
        clock.real_time_factor = factor
    assert clock.real_time_factor == 1.0


def test_reset_goes_to_a_time():
    """A reset sets the time and keeps pause and factor."""
    clock = SimClock(STEP, 5, paused=True, real_time_factor=2.0)
    clock.advance()
    clock.reset()
    assert (clock.now_ns, clock.paused, clock.real_time_factor) == (0, True, 2.0)
