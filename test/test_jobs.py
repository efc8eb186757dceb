# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The jobs of `make test`, tried on small suites."""

import os
from pathlib import Path
import re
import subprocess
import sys

import pytest

ROOT = Path(__file__).parents[1]
INI = f"""
[pytest]
pythonpath = {ROOT / 'test/support'}
addopts = -p no:cacheprovider -p no:armsim -p no:hypothesispytest -ra
markers = alone
faulthandler_timeout = 2
faulthandler_exit_on_timeout = true
"""
CONFTEST = """
from pathlib import Path
from jobs import ByStack, ChosenJob, JOBS
import pytest

NODES = Path(__file__).parent / 'nodes'

def pytest_addoption(parser):
    parser.addoption('--job', choices=JOBS)

def pytest_configure(config):
    config.pluginmanager.register(ByStack([NODES / 'shared']))
    if config.option.job:
        config.pluginmanager.register(ChosenJob(config.option.job, [NODES / 'long', NODES]))

@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    report = yield
    report.user_properties += [('id', item.nodeid), ('pressure', 0.9 * ('starved' in item.name))]
    return report

@pytest.fixture
def attempts(request):
    place = Path(f'{request.node.name}.attempts')
    with place.open('a') as file:
        file.write('x')
    return len(place.read_text())
"""
STARVED = """
import pytest

@pytest.mark.parametrize('number', range({count}))
def test_{name}(attempts, number):
    assert attempts == {good}, 'came late'
"""
NODES = 'nodes/test_it.py'
#: Enough for the tests of one file.
ONE_WORKER = ('--workers', '1')


@pytest.fixture
def make_test(tmp_path):
    """Return a function that runs a suite, file -> text, and gives status and output."""
    environment = {key: value for key, value in os.environ.items() if 'PYTEST' not in key}

    def run(files, *arguments):
        for name, text in {'pytest.ini': INI, 'conftest.py': CONFTEST, **files}.items():
            file = tmp_path / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        script = subprocess.run(
            [sys.executable, ROOT / 'scripts/run_tests.py', *arguments], cwd=tmp_path,
            env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        return script.returncode, script.stdout

    return run


def starved(name='starved', count=1, good=2):
    """Return tests that fail under pressure, but for one attempt."""
    return STARVED.format(name=name, count=count, good=good)


def test_failures_under_pressure_run_again_once(make_test):
    """They are told with their reasons and the pressure; the run is green where they pass then."""
    status, text = make_test({NODES: starved(count=3)}, '--job', 'real-time', *ONE_WORKER)
    assert status == 0, text
    assert re.search(r'90% waited, +0% kept; then passed: nodes/test_it.py::test_starved\[2\]\n'
                     r' +AssertionError: came late', text), text
    assert re.search(r'\n3 tests in 0 min \d+ s: 0 failed, 3 run again\n', text), text


@pytest.mark.parametrize(('count', 'arguments'), [(1, ['--no-reruns']), (4, [])])
def test_nothing_runs_again(make_test, count, arguments):
    """Told so, and beyond three: the run has failed."""
    status, text = make_test(
        {NODES: starved(count=count)}, '--job', 'real-time', *ONE_WORKER, *arguments)
    assert status == 1, text
    assert f'then not run again: {NODES}::test_starved[0]' in text
    assert re.search(rf'\n{count} tests in .*: {count} failed, 0 run again\n', text), text


def test_each_job_has_its_tests_and_other_failures_stay(make_test):
    """
    Folders of programs, their tests that need the machine alone, and all the others.

    A failure stays at the second attempt, without pressure, or of a core test.
    """
    status, text = make_test({
        'test_core.py': starved('starved_core')
        + '@pytest.mark.skip(reason="no key")\ndef test_core(): pass',
        NODES: starved() + starved('starved_twice', good=3) + starved('slow'),
        'nodes/test_two.py': 'import pytest\n@pytest.mark.alone\ndef test_alone(): pass',
    }, '-v', *ONE_WORKER)
    assert status == 1, text
    jobs = re.split('\n== (.*) tests\n|\n== failed under pressure', text)[1:]
    for name, output, tests in zip(jobs[::2], jobs[1::2], (
            {'starved_core', 'core'}, {'starved', 'starved_twice', 'slow'}, {'alone'}),
            strict=False):
        assert set(re.findall(r'::test_(\w+)', output)) == tests, name
    assert jobs[:6:2] == ['core', 'real-time', 'alone']
    assert f'then passed: {NODES}::test_starved[0]' in text
    assert f'then failed: {NODES}::test_starved_twice[0]' in text
    assert re.search(r'\n6 tests in .*: 3 failed, 2 run again\nskipped: 1 no key\n', text), text


def test_a_test_that_hangs_with_the_lock_of_python_fails(make_test):
    """Its worker ends and is replaced, and the other tests run; nothing runs again."""
    status, text = make_test({NODES: """
import ctypes

def test_before(): pass
def test_starved(): ctypes.PyDLL(None).sleep(600)
def test_after(): pass
"""}, '--job', 'real-time', *ONE_WORKER)
    assert status == 1
    assert f"crashed while running '{NODES}::test_starved'" in text
    assert re.search(r'\n3 tests in .*: 1 failed, 0 run again\n', text), text


def test_what_shares_a_stack_runs_in_one_worker(make_test, tmp_path):
    """All files of its folder; others run meanwhile elsewhere."""
    shared = """
import os, pathlib
def test_it():
    pathlib.Path(os.environ['PYTEST_XDIST_WORKER'] + '.' + __name__[-1]).touch()
"""
    waits = """
import pathlib, time
def test_it():
    while len(list(pathlib.Path().glob('gw?.[0-9]'))) < 6:
        time.sleep(0.01)
"""
    files = {f'nodes/shared/test_{number}.py': shared for number in range(6)}
    status, text = make_test({**files, 'nodes/test_waits.py': waits}, '--job', 'real-time')
    assert status == 0, text
    assert len({file.name[:3] for file in tmp_path.glob('gw?.?')}) == 1


def test_folders_run_in_the_order_of_their_list(make_test):
    """So that long ones begin first."""
    status, text = make_test({
        'nodes/a/test_short.py': 'def test_short(): pass',
        'nodes/long/test_long.py': 'def test_long(): pass',
    }, '--job', 'real-time', '--workers', '0', '-v')
    assert status == 0, text
    assert re.findall(r'::(test_\w+) PASSED', text) == ['test_long', 'test_short']


def test_nothing_collected_is_told(make_test):
    """As pytest's status does."""
    status, _ = make_test({NODES: starved()}, '--job', 'core')
    assert status == 5
