# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Refusals of programs, which a bringup reports once for all its programs."""

from __future__ import annotations

from contextlib import suppress
import sys

from armsim_ros.cli.environment import started_by_bringup

#: Begins each line of a refusal that a bringup reads: the ASCII record separator.
MARK = '\x1e'


def refuse(text: str) -> None:
    """Write why the program does not run to standard error; where that is full, do not wait."""
    mark = MARK if started_by_bringup() else ''
    with suppress(OSError):
        print('\n'.join(mark + line for line in text.splitlines()), file=sys.stderr, flush=True)
