# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Times and durations: ``builtin_interfaces`` to nanoseconds and seconds."""

from __future__ import annotations

import math

from builtin_interfaces.msg import Duration, Time

NANOSECONDS = 1_000_000_000


def time_from_ns(ns: int) -> Time:
    """
    Return a stamp.

    :param ns: [ns] since the epoch, not negative.
    """
    sec, nanosec = divmod(ns, NANOSECONDS)
    return Time(sec=sec, nanosec=nanosec)


def fill_time(message: Time | Duration, ns: int) -> None:
    """
    Write a time into an existing stamp.

    :param ns: [ns] since the epoch, not negative.
    """
    message.sec, message.nanosec = divmod(ns, NANOSECONDS)


def ns_from_time(message: Time) -> int:
    """Return a stamp as [ns] since the epoch."""
    return int(message.sec) * NANOSECONDS + int(message.nanosec)


def duration_from_seconds(seconds: float) -> Duration:
    """
    Return a duration.

    :param seconds: [s]; its nanoseconds are rounded, the sign is carried by the seconds.
    """
    message = Duration()
    fill_duration(message, seconds)
    return message


def fill_duration(message: Duration, seconds: float) -> None:
    """
    Write a duration into an existing message.

    :param seconds: [s], see :func:`ns_from_seconds`.
    """
    message.sec, message.nanosec = divmod(ns_from_seconds(seconds), NANOSECONDS)


def ns_from_seconds(seconds: float) -> int:
    """
    Return a duration as [ns].

    :param seconds: [s]; NaN counts as 0, what does not fit 32 bit is cut.
    """
    if math.isnan(seconds):
        seconds = 0.0
    return round(min(max(seconds, -2.0**31), 2.0**31 - 1.0) * NANOSECONDS)


def seconds_from_duration(message: Duration) -> float:
    """Return a duration in [s]."""
    return float(int(message.sec) * NANOSECONDS + int(message.nanosec)) / NANOSECONDS
