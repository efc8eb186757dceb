# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether this machine gave the tests the processors that it pretends to have."""

import os
from pathlib import Path

#: Share of the processors' time that a host may keep to itself before real time is none.
MOST_STOLEN = 0.04
#: Columns of the first line of /proc/stat, see proc(5).
_STOLEN, _ALL = 7, 8


class Machine:
    """Measures what the host of a virtual machine takes away; nothing elsewhere."""

    def __init__(self):
        self._since = self._times()

    def begin(self):
        """Measure from now on."""
        self._since = self._times()

    def was_starved(self):
        """
        Return whether programs had to wait for a processor for a noticeable part of the time.

        Tests that run beside others are no measure of what happens in real time.
        """
        if 'PYTEST_XDIST_WORKER' in os.environ:
            return True
        now = self._times()
        spent = [after - before for before, after in zip(self._since, now, strict=True)]
        return sum(spent) > 0 and spent[_STOLEN] > MOST_STOLEN * sum(spent)

    @staticmethod
    def _times():
        line = Path('/proc/stat').read_text().splitlines()[0]
        return [int(word) for word in line.split()[1:_ALL + 1]]
