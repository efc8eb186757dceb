# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Deadlines, with an invented clock."""

import pytest

from armsim_ros.sim.pacer import Bell, Pacer

PERIOD = 1_000_000


class InventedClock:
    """Time that passes only by sleeping, and by what a test adds."""

    def __init__(self):
        self.now = 0
        self.oversleep = 0
        self.naps = []

    def __call__(self):
        return self.now

    def sleep(self, seconds):
        """Pass the time asked for and a little more."""
        self.naps.append(seconds)
        self.now += round(seconds * 1e9) + self.oversleep


@pytest.fixture
def clock():
    """Return a clock at 0."""
    return InventedClock()


@pytest.fixture
def pacer(clock):
    """Return a pacer that makes up 10 ms."""
    return Pacer(clock=clock, sleep=clock.sleep, catch_up_ns=10 * PERIOD)


def test_deadlines_do_not_drift(clock, pacer):
    """Waking 50 us late each time does not add up: deadlines are absolute."""
    clock.oversleep = 50_000
    lateness = [pacer.wait(PERIOD) for _ in range(100)]
    assert set(lateness) == {50_000}
    assert clock.now == 100 * PERIOD + 50_000


def test_statistics_tell_the_lateness(clock, pacer):
    """Median, 99th percentile and maximum are those of the waits."""
    for i in range(200):
        clock.oversleep = 300_000 if i == 100 else 10_000
        pacer.wait(PERIOD)
    statistics = pacer.statistics()
    assert (statistics.ticks, statistics.p50_ns, statistics.p99_ns) == (200, 10_000, 10_000)
    assert (statistics.max_ns, statistics.overruns, statistics.dropped_ns) == (300_000, 0, 0)


def test_makes_up_a_short_delay(clock, pacer):
    """After 5 ms of delay the next ticks come without a wait until it is made up."""
    pacer.wait(PERIOD)
    clock.now += 5 * PERIOD
    clock.naps.clear()
    for _ in range(6):
        pacer.wait(PERIOD)
    assert clock.now == 7 * PERIOD
    assert len(clock.naps) == 1
    assert pacer.statistics().overruns > 0
    assert pacer.statistics().dropped_ns == 0


def test_drops_what_is_too_much_to_make_up(clock, pacer):
    """Of a delay of 50 ms only 10 ms are made up; the rest is counted."""
    pacer.wait(PERIOD)
    clock.now += 50 * PERIOD
    for _ in range(30):
        pacer.wait(PERIOD)
    assert pacer.statistics().dropped_ns == 39 * PERIOD
    assert clock.now == (1 + 39 + 30) * PERIOD


def test_makes_up_what_the_start_has_held_up(clock):
    """In the first seconds a long delay is made up as a whole, later it is not."""
    pacer = Pacer(
        clock=clock, sleep=clock.sleep, catch_up_ns=10 * PERIOD, catch_up_at_start_ns=1000 * PERIOD
    )
    clock.now += 700 * PERIOD
    for _ in range(6000):
        pacer.wait(PERIOD)
    assert (pacer.statistics().dropped_ns, clock.now) == (0, 6000 * PERIOD)
    clock.now += 700 * PERIOD
    pacer.wait(PERIOD)
    assert pacer.statistics().dropped_ns > 600 * PERIOD


def test_a_loop_that_cannot_keep_the_pace_leaves_time_to_others(clock, pacer):
    """Ticks that take twice their period are followed by sleeps: a fifth of the time in all."""
    for _ in range(1000):
        clock.now += 2 * PERIOD
        pacer.wait(PERIOD)
    assert sum(clock.naps) * 1e9 == pytest.approx(0.2 * clock.now, rel=0.02)


def test_the_pace_tells_whether_time_keeps_up(clock, pacer):
    """With ticks that take twice their period the pace is a half of what is not left to others."""
    for _ in range(3000):
        pacer.wait(PERIOD)
        clock.now += 2 * PERIOD
    assert pacer.statistics().pace == pytest.approx(0.4, abs=0.01)


def test_spins_at_the_end_of_a_wait():
    """With a spin the sleep ends before the deadline and the clock is polled from there."""
    clock = InventedClock()

    def poll():
        clock.now += 1000
        return clock.now

    pacer = Pacer(clock=poll, sleep=clock.sleep, spin_ns=100_000)
    late = pacer.wait(PERIOD)
    assert clock.naps[0] < 0.0009
    assert late <= 2000


def test_start_forgets(clock, pacer):
    """A new start counts from now."""
    pacer.wait(PERIOD)
    clock.now += 500 * PERIOD
    pacer.start()
    assert pacer.wait(PERIOD) == 0
    assert pacer.statistics().ticks == 1


def test_a_bell_that_rings_ends_one_wait():
    """However often it rang before, the wait ends at once; the next one is a new one."""
    bell = Bell()
    bell.set()
    bell.set()
    assert bell.wait(60.0)
    assert not bell.wait(0.0)
    bell.set()
    bell.clear()
    assert not bell.wait(0.0)
