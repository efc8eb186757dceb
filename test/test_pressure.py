# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a test's report says of the machine."""

import os

from pressure import Pressure, Reading
import pytest


def test_shares_of_the_time_between_two_readings():
    """Pressure is a share of the time, steal one of the time of all processors."""
    begin = Reading(time=10.0, waiting=3.0, steal=1.0)
    end = Reading(time=14.0, waiting=5.0, steal=1.0 + 0.4 * os.cpu_count())
    assert end.since(begin) == [('pressure', 0.5), ('steal', 0.1)]


def test_counters_only_grow():
    """They are read in seconds."""
    earlier, later = Reading.now(), Reading.now()
    assert 0.0 <= earlier.waiting <= later.waiting < later.time * os.cpu_count()
    assert 0.0 <= earlier.steal <= later.steal < later.time * os.cpu_count()


@pytest.mark.parametrize(('text', 'names'), [
    ('pass', ['id', 'pressure', 'steal']), ('assert 0', ['id', 'pressure', 'steal'] * 2)])
def test_each_test_is_measured(pytester, text, names):
    """The end of each test has the figures; a failure has those until then, too."""
    pytester.makepyfile(f'def test_it(): {text}')
    run = pytester.inline_run('-p', 'no:cacheprovider', plugins=[Pressure()])
    reports = run.getreports('pytest_runtest_logreport')
    properties = [each for report in reports for each in report.user_properties]
    assert [name for name, _ in properties] == names
    assert dict(properties)['id'] == 'test_each_test_is_measured.py::test_it'
