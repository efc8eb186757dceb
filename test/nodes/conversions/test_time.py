# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Stamps and durations."""

from builtin_interfaces.msg import Duration, Time
import pytest

from armsim_ros.nodes.conversions.time import (
    duration_from_seconds,
    ns_from_time,
    seconds_from_duration,
    time_from_ns,
)


def test_a_stamp_goes_there_and_back() -> None:
    """Nanoseconds survive the way through a message."""
    stamp = time_from_ns(1_700_000_000_123_456_789)
    assert (stamp.sec, stamp.nanosec) == (1_700_000_000, 123_456_789)
    assert ns_from_time(stamp) == 1_700_000_000_123_456_789


@pytest.mark.parametrize('seconds', [0.0, 0.1, 1.999999999, 12345.678])
def test_a_duration_goes_there_and_back(seconds: float) -> None:
    """Seconds survive to the nanosecond."""
    message = duration_from_seconds(seconds)
    assert seconds_from_duration(message) == pytest.approx(seconds, abs=1e-9)


def test_a_negative_duration_has_positive_nanoseconds() -> None:
    """-0.25 s is -1 s and 750 ms, as ROS has it."""
    message = duration_from_seconds(-0.25)
    assert (message.sec, message.nanosec) == (-1, 750_000_000)
    assert seconds_from_duration(Duration(sec=-1, nanosec=0)) == -1.0


@pytest.mark.parametrize('seconds', [float('nan'), float('inf'), 1e30, -1e30])
def test_what_does_not_fit_is_cut(seconds: float) -> None:
    """No number makes a message that cannot be sent."""
    message = duration_from_seconds(seconds)
    assert -(2**31) <= message.sec < 2**31
    assert 0 <= message.nanosec < 1_000_000_000


def test_a_stamp_of_zero_is_zero() -> None:
    """0 means "now" in a trajectory and must stay exactly 0."""
    assert ns_from_time(Time()) == 0
