# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What looks at times runs in two workers, however many there are."""

from pathlib import Path

TESTS = """
import os, pathlib, pytest, time

@pytest.mark.parametrize('number', range(3))
def test_it(number, tmp_path_factory):
    worker = os.environ['PYTEST_XDIST_WORKER']
    assert (os.nice(0) > int(os.environ['NICENESS'])) == (worker == 'gw2')
    place = tmp_path_factory.getbasetemp().parent / pathlib.Path(__file__).stem
    place.mkdir(exist_ok=True)
    (place / worker).touch()
    end = time.monotonic() + 60
    while 'real_time' in place.name and not list(place.parent.glob('*patient*/gw2')):
        assert time.monotonic() < end, 'the third worker does not help'
        time.sleep(0.01)
"""
FILES = {'real_time': 12, 'patient': 6, 'core': 2}
CONFTEST = """
import os
from spare_worker import Kind, SpareWorker

def pytest_configure(config):
    os.environ.setdefault('NICENESS', str(os.nice(0)))
    config.pluginmanager.register(SpareWorker(config, kind_of))

def kind_of(path):
    return next(kind for kind in Kind if kind.name.lower() in path.name)
"""


def test_a_third_worker_runs_no_tests_of_real_time(pytester, monkeypatch):
    """Every test runs; the third worker begins with those that compute, and helps out."""
    monkeypatch.setenv('PYTHONPATH', str(Path(__file__).parent / 'support'))
    monkeypatch.delenv('PYTEST_XDIST_WORKER', raising=False)
    monkeypatch.delenv('NICENESS', raising=False)
    pytester.makeconftest(CONFTEST)
    pytester.makepyfile(**{f'test_{name}_{n}': TESTS
                           for name, count in FILES.items() for n in range(count)})
    base = pytester.path / 'base'

    result = pytester.runpytest_subprocess(
        '-n', '3', '--dist', 'loadfile', '--no-loadscope-reorder', f'--basetemp={base}',
        '-p', 'no:armsim', '-p', 'no:hypothesispytest', timeout=120)

    result.assert_outcomes(passed=3 * sum(FILES.values()))
    workers = {name: {file.name for file in base.glob(f'*{name}*/gw*')} for name in FILES}
    assert workers['real_time'] == {'gw0', 'gw1'}
    assert 'gw2' in workers['core']
    assert 'gw2' in workers['patient']
