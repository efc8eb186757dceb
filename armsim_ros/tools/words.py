# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Command lines in the style of ros2 launch for argparse."""

from __future__ import annotations

from collections.abc import Iterable


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
