# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Many tests at a time: nobody in another's way, nothing left behind."""

from contextlib import ExitStack
import os
from pathlib import Path
import signal
import sys
import threading
import time

import pytest

from armsim_ros.testing.program import private_domain, Program

statement = pytest.mark.statement

IN_PROCESS = """
import pytest
from armsim_ros.testing import assert_reached

DIGESTS = set()


@pytest.mark.parametrize('number', range({count}))
def test_goes_its_own_way(arm, number):
    DIGESTS.add(arm.digest())
    arm.spawn('box', xyz=(1.0, 0.0, 0.5), mass=0.2)
    turned = dict.fromkeys(arm.joints, 0.01 * (number % 20 + 1))
    arm.follow([(0.5, turned)])
    assert_reached(arm, turned)
    assert len(DIGESTS) == 1
"""

PROGRAMS = """
import os
from pathlib import Path
import threading

import pytest
from armsim_ros.testing import assert_reached


@pytest.mark.armsim(mode='process', time_limit=300)
@pytest.mark.parametrize('number', range(2))
def test_has_programs_of_its_own(arm, ros_domain, number):
    pid = arm.robot.program.process.pid
    Path(__file__).with_suffix('.pids').write_text(f'{{os.getpid()}} {{pid}} {{ros_domain}}')
    if {hangs}:
        threading.Event().wait()
    turned = dict.fromkeys(arm.joints, 0.1 * (number + 1))
    arm.follow([(0.5, turned)])
    assert_reached(arm, turned)
"""


@pytest.fixture
def two_domains():
    """Return the option that leaves two domains to the tests within, which nobody else uses."""
    with private_domain(range(60, 80, 2)) as first:
        pair = range(first, first + 2)
    return pair


def assert_free(domains):
    """Fail where a domain is still leased."""
    with ExitStack() as leases:
        for domain in domains:
            leases.enter_context(private_domain(range(domain, domain + 1)))


def children_of(pid):
    """Return the folders in /proc of a program and of all that it has started."""
    path = Path('/proc', str(pid), 'task', str(pid), 'children')
    below = path.read_text().split() if path.exists() else []
    return [Path('/proc', str(pid)), *(one for child in below for one in children_of(child))]


def wait_until(condition, timeout=120.0):
    """Look until something is so."""
    deadline, pause = time.monotonic() + timeout, threading.Event()
    while not condition():
        assert time.monotonic() < deadline
        pause.wait(0.1)


@pytest.mark.timeout(900)
@statement('G4', 'G5')
def test_forty_tests_on_two_workers_leave_nothing(run_tests, pytester, two_domains):
    """In-process and process tests side by side pass; no program, domain or file is left."""
    for name in ('test_first', 'test_second'):
        pytester.makepyfile(**{name: PROGRAMS.format(hangs=False)})
    result = run_tests(
        IN_PROCESS.format(count=36), '-n2', '--dist=loadfile', f'--rootdir={pytester.path}',
        f'--armsim-domains={two_domains[0]}-{two_domains[-1]}')
    result.assert_outcomes(passed=40)
    told = [path.read_text().split() for path in pytester.path.glob('*.pids')]
    assert {int(domain) for _, _, domain in told} <= set(two_domains)
    assert not any(Path('/proc', pid).exists() for _, pid, _ in told)
    assert not (pytester.path / 'armsim-artifacts').exists()
    assert_free(two_domains)


@pytest.mark.timeout(900)
@statement('G5')
def test_killed_and_interrupted_workers_leave_nothing(pytester, strangers_pytest, two_domains):
    """Programs and domain of a worker go with it when it is killed, all go with Ctrl-C."""
    files = [Path(pytester.makepyfile(**{name: PROGRAMS.format(hangs=True)}))
             for name in ('test_first', 'test_second')]
    notes = [path.with_suffix('.pids') for path in files]
    command = [
        sys.executable, '-m', 'pytest', '-n2', '--dist=loadfile',
        '--max-worker-restart=0', f'--rootdir={pytester.path}', *map(str, files),
        f'--armsim-domains={two_domains[0]}-{two_domains[-1]}',
    ]
    with Program(command) as tests:
        wait_until(lambda: all(note.exists() and len(note.read_text().split()) == 3
                               for note in notes), 240.0)
        told = [tuple(map(int, note.read_text().split())) for note in notes]
        assert {domain for _, _, domain in told} == set(two_domains)
        programs = {worker: children_of(bringup) for worker, bringup, _ in told}
        assert all(len(found) >= 3 for found in programs.values())
        killed, other = programs
        os.kill(killed, signal.SIGKILL)
        wait_until(lambda: not any(path.exists() for path in programs[killed]))
        assert all(path.exists() for path in programs[other])
        os.killpg(tests.process.pid, signal.SIGINT)
        wait_until(lambda: not any(path.exists() for path in programs[other]))
        tests.wait(120.0)
    assert_free(two_domains)
