# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Programs in real time run in two workers, however many there are."""

from pathlib import Path

TESTS = """
import os, pathlib, pytest

@pytest.mark.parametrize('number', range(3))
def test_it(number, tmp_path_factory):
    worker = os.environ['PYTEST_XDIST_WORKER']
    assert (os.nice(0) > int(os.environ['NICENESS'])) == (worker == 'gw2')
    place = tmp_path_factory.getbasetemp().parent / pathlib.Path(__file__).stem
    place.mkdir(exist_ok=True)
    (place / worker).touch()
"""
CONFTEST = """
import os
from spare_worker import SpareWorker

def pytest_configure(config):
    os.environ.setdefault('NICENESS', str(os.nice(0)))
    config.pluginmanager.register(SpareWorker(config, lambda path: 'moves' in path.name))
"""


def test_a_third_worker_runs_core_tests_alone(pytester, monkeypatch):
    """Every test runs, those of real-time programs in the first two workers."""
    monkeypatch.setenv('PYTHONPATH', str(Path(__file__).parent / 'support'))
    monkeypatch.delenv('PYTEST_XDIST_WORKER', raising=False)
    monkeypatch.delenv('NICENESS', raising=False)
    pytester.makeconftest(CONFTEST)
    pytester.makepyfile(**{f'test_{name}_{n}': TESTS
                           for name in ('moves', 'plans') for n in range(4)})
    base = pytester.path / 'base'

    result = pytester.runpytest_subprocess(
        '-n', '3', '--dist', 'loadfile', '--no-loadscope-reorder', f'--basetemp={base}',
        '-p', 'no:armsim', '-p', 'no:hypothesispytest', timeout=120)

    result.assert_outcomes(passed=24)
    workers = {name: {file.name for file in base.glob(f'*{name}*/gw*')}
               for name in ('moves', 'plans')}
    assert workers['moves'] == {'gw0', 'gw1'}
    assert 'gw2' in workers['plans']
