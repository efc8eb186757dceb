# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which part of a recording is played."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable
import re

from armsim_ros2.errors import CliError

_SECOND = 1_000_000_000


def check_expressions(options: Namespace) -> None:
    """
    Check the regular expressions of a command line.

    :raises CliError: one is not a regular expression.
    """
    for text in (options.regex, options.exclude_regex):
        try:
            re.compile(text)
        except re.error as error:
            raise CliError(f"'{text}' is not a regular expression: {error}") from None


def is_played(topic: str, options: Namespace, absolute: Callable[[str], str]) -> bool:
    """
    Return whether a recorded topic is played.

    :param absolute: returns the full name of a topic.
    """
    left_out = [*map(absolute, options.exclude_topics), *(['/clock'] if options.clock else [])]
    if topic in left_out or (options.exclude_regex
                             and re.fullmatch(options.exclude_regex, topic)):
        return False
    if not options.topics and not options.regex:
        return True
    return topic in map(absolute, options.topics) or bool(
        options.regex and re.fullmatch(options.regex, topic))


def last_played(first: int, options: Namespace) -> int | None:
    """
    Return the time of the recording after which nothing is played [ns], None for its end.

    :param first: the time that playing begins with [ns].
    """
    until = options.playback_until_nsec
    if options.playback_until_sec >= 0.0:
        until = int(options.playback_until_sec * _SECOND)
    if options.playback_duration < 0.0 and until < 0:
        return None
    duration = round(options.playback_duration * _SECOND)
    # A time of 0 ends at once, as upstream.
    return max(first + duration if duration > 0 else 0, until) or -1
