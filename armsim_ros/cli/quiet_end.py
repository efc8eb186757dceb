# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""An end of the process without messages of libraries."""

from __future__ import annotations

import atexit
import os
import sys


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
