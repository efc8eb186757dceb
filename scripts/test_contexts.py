# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A plug-in of pytest for ``mutants.py``: names the running test to coverage, and times it.

In pytest's own process a line is attributed to the test, in programs to the file of the test that
started them.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
import json
import os
from pathlib import Path

import coverage
import pytest

_DURATIONS: defaultdict[str, float] = defaultdict(float)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Attribute lines to the test from here on."""
    running = coverage.Coverage.current()
    if running is not None:
        running.switch_context(item.nodeid)
    os.environ['TEST_CONTEXT'] = item.nodeid.partition('::')[0]
    return (yield)


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Count the time of set-up, call and teardown of tests that pass."""
    if report.outcome == 'passed':
        _DURATIONS[report.nodeid] += report.duration
    else:
        _DURATIONS[report.nodeid] = -1e9


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Add the durations of the tests that passed [s]; workers report to their caller."""
    if hasattr(session.config, 'workerinput'):
        return
    file = Path(os.environ['TEST_DURATIONS'])
    known = json.loads(file.read_text()) if file.is_file() else {}
    file.write_text(json.dumps({**known, **{
        test: round(seconds, 3) for test, seconds in _DURATIONS.items() if seconds >= 0}}))
