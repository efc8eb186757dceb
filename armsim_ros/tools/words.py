# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Command lines in the style of ros2 launch for argparse."""

from __future__ import annotations

import argparse
from collections.abc import Iterable


def part_words(words: Iterable[str], parser: argparse.ArgumentParser
               ) -> tuple[list[str], dict[str, str]]:
    """
    Part the words of a program from the arguments for a robot's xacro.

    :returns: the words that are no ``name:=value`` or name an option of the parser, and the
        others by name.
    """
    own: list[str] = []
    others: dict[str, str] = {}
    for word in words:
        name, sign, value = word.partition(':=')
        if sign and f"--{name.strip('-').replace('_', '-')}" not in parser._option_string_actions:
            others[name] = value
        else:
            own.append(word)
    return own, others


def argparse_words(words: Iterable[str]) -> list[str]:
    """Return the words with each ``name:=value`` as ``--name=value``."""
    result = []
    for word in words:
        name, sign, value = word.partition(':=')
        if sign and name.strip('-').replace('_', '').isalnum():
            result.append(f"--{name.strip('-').replace('_', '-')}={value}")
        else:
            result.append(word)
    return result
