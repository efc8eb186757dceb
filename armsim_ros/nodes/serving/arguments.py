# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Command lines of programs that are no program of a robot: ``name:=value`` and nothing else."""

from __future__ import annotations

from collections.abc import Sequence

from armsim_ros.cli.arguments import split_ros_args, UsageError
from armsim_ros.errors import nearest


def read_values(argv: Sequence[str], known: Sequence[str]
                ) -> tuple[dict[str, str], tuple[str, ...]]:
    """
    Read ``name:=value``, ``--name value`` and ``--name=value``; the last of several wins.

    :param known: the names that are allowed.
    :returns: the values, and the words for ROS.
    :raises UsageError: names the known arguments.
    """
    words, ros_args = split_ros_args(argv)
    values: dict[str, str] = {}
    rest = list(words)
    while rest:
        word = rest.pop(0)
        name, sign, text = word.partition(':=')
        if word.startswith('--'):
            name, sign, text = word[2:].partition('=')
            name = name.removesuffix(':')
            if not sign and rest:
                sign, text = '=', rest.pop(0)
        if name not in known:
            hint = nearest(name, known) or f"known: {', '.join(known)}"
            raise UsageError(f"unknown argument '{word}'; {hint}")
        if not sign or not text:
            raise UsageError(f"argument '{name}' needs a value: {name}:=VALUE")
        values[name] = text
    return values, ros_args
