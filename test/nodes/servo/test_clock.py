# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which clock counts, and when /clock is subscribed to."""

import time
from types import SimpleNamespace

import pytest

from armsim_ros.nodes.servo.inputs import StreamClock


@pytest.fixture
def node():
    """Return a node whose time is simulated and comes from /clock once it is followed."""
    made = SimpleNamespace(clock_ns=0, followed=False)
    made.get_parameter = lambda name: SimpleNamespace(value=True)
    made.get_clock = lambda: SimpleNamespace(
        now=lambda: SimpleNamespace(nanoseconds=made.clock_ns))
    made.follow_clock = lambda: setattr(made, 'followed', True)
    return made


def test_stamps_that_agree_are_enough(node):
    """Where joint states are stamped with the wall clock's time /clock is left alone."""
    clock = StreamClock(node)
    for stamp in (0, time.time_ns(), time.time_ns()):
        clock.look(stamp)
        assert not clock.parted
    assert not node.followed
    assert abs(clock.now_ns() - time.time_ns()) < 1_000_000_000


def test_time_that_stands_still(node):
    """Stamps that fall behind have /clock followed, and until it comes they are the time."""
    clock = StreamClock(node)
    clock.look(5_000_000_000)
    assert clock.parted
    assert node.followed
    assert clock.now_ns() == 5_000_000_000
    node.clock_ns = 5_020_000_000
    assert clock.now_ns() == 5_020_000_000


def test_time_that_goes_on(node):
    """Once stamps are the wall clock's time again, so is the time of commands."""
    clock = StreamClock(node)
    clock.look(5_000_000_000)
    clock.look(time.time_ns())
    assert not clock.parted
