# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How much of the processors programs lacked during a test."""

from dataclasses import dataclass
import os
from pathlib import Path
import re
import time

import pytest

#: Column of the first line of /proc/stat with the time that the host kept, see proc(5).
_STEAL = 7


@dataclass(frozen=True)
class Reading:
    """
    Counters of the kernel at a time.

    :param waiting: time in which some program waited for a processor [s].
    :param steal: time of all processors that the host of a virtual machine kept [s].
    """

    time: float
    waiting: float
    steal: float

    @classmethod
    def now(cls):
        """Read the counters; those that this kernel does not have stay at 0."""
        return cls(time.monotonic(), _waiting(), _stolen())

    def since(self, earlier):
        """
        Return what a test's report records.

        :return: shares of the time between two readings: ``pressure``, the 'some' of
            /proc/pressure/cpu, and ``steal``, of the time of all processors.
        """
        seconds = max(self.time - earlier.time, 1e-3)
        return [
            ('pressure', round((self.waiting - earlier.waiting) / seconds, 3)),
            ('steal', round((self.steal - earlier.steal) / seconds / os.cpu_count(), 3)),
        ]


def _waiting():
    try:
        line = Path('/proc/pressure/cpu').read_text()
    except OSError:
        return 0.0
    return int(re.search(r'^some .*total=(\d+)', line)[1]) * 1e-6


def _stolen():
    try:
        columns = Path('/proc/stat').read_text().split(maxsplit=_STEAL + 2)
    except OSError:
        return 0.0
    return int(columns[_STEAL + 1]) / os.sysconf('SC_CLK_TCK')


class Pressure:
    """A plugin that adds pressure and steal to the user properties of each test's reports."""

    def __init__(self):
        self._begin = Reading.now()

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self):
        """Begin to measure."""
        self._begin = Reading.now()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item):
        """Record what was measured until now, and the test's full name."""
        report = yield
        if report.failed or report.when == 'teardown':
            report.user_properties += [('id', item.nodeid), *Reading.now().since(self._begin)]
        return report
