# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A worker that says nothing any more does not keep the others waiting for ever."""

from pathlib import Path

TESTS = """
import os, pathlib, signal, pytest

@pytest.mark.parametrize('number', range(5))
def test_stopped_once(number, tmp_path_factory):
    seen = tmp_path_factory.getbasetemp().parent / 'seen'
    if number == 2 and not seen.exists():
        seen.touch()
        os.kill(os.getpid(), signal.SIGSTOP)
"""
CONFTEST = """
from silent_workers import SilentWorkers

def pytest_configure(config):
    config.pluginmanager.register(SilentWorkers(longest=3.0))
"""


def test_a_stopped_worker_is_told_of_and_replaced(pytester, monkeypatch):
    """Its test is named as failed, and the rest of its tests are run by another worker."""
    monkeypatch.setenv('PYTHONPATH', str(Path(__file__).parent / 'support'))
    monkeypatch.delenv('PYTEST_XDIST_WORKER', raising=False)
    pytester.makeconftest(CONFTEST)
    pytester.makepyfile(test_stopped=TESTS, test_other='def test_other(): pass')

    result = pytester.runpytest_subprocess(
        '-n', '2', '--dist', 'loadfile', '-p', 'no:armsim',
        '-p', 'no:hypothesispytest', timeout=120)

    result.assert_outcomes(passed=6, failed=1)
    result.stderr.fnmatch_lines(['no worker has reported for 3 s*test_stopped_once?2?*'])
