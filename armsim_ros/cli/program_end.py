# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Ends of programs: refusals that bringup reports once, and an end without library messages."""

from __future__ import annotations

import atexit
from contextlib import suppress
import os
import sys

from armsim_ros.cli.environment import started_by_bringup

#: Begins each line of a refusal that a bringup reads: the ASCII record separator.
MARK = '\x1e'


def refuse(text: str) -> None:
    """Write why the program does not run to standard error; where that is full, do not wait."""
    mark = MARK if started_by_bringup() else ''
    with suppress(OSError):
        print('\n'.join(mark + line for line in text.splitlines()), file=sys.stderr, flush=True)


class QuietEnd:
    """
    Ends the process before its libraries report leaks.

    OMPL's bindings print a page about that, below what the user should read.

    :param status: of the process; None lets it end as usual.
    """

    def __init__(self, status: int | None = None) -> None:
        self.status = status
        atexit.register(self._leave)

    def _leave(self) -> None:
        if self.status is not None:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(self.status)
