# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""One running default robot for all verbs of the ros2 command."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager, ExitStack
from dataclasses import dataclass
from multiprocessing import get_context
import os
from pathlib import Path
import subprocess
import sys

from command_process import prepare, run_in
import pytest

from armsim_ros.cli.environment import FASTDDS_PROFILES
from armsim_ros.testing.program import private_domain, ros_environment, start_program

READY = 'You can start planning now!'
START_TIMEOUT = 60.0
#: Half the usual rate of /clock: the robot runs while the tests wait for discovery.
CALMER = 'overrides:={simulation.clock_rate: 50}'
#: How long a command waits for a name that it does not know yet, and for one that nobody has [s].
PATIENCE, SHORT_PATIENCE = 10.0, 0.3
NOBODYS = '/nope'
SOURCES = Path(__file__).parents[3] / 'ros2'


@dataclass(frozen=True)
class Done:
    """
    What a command did.

    :param out: its standard output.
    :param err: its standard error.
    """

    status: int
    out: str
    err: str

    @property
    def lines(self) -> list[str]:
        """The lines of the output."""
        return self.out.splitlines()


Ros2 = Callable[..., Done]


@contextmanager
def running_robot() -> Iterator[int]:
    """Run the default robot, with the package's settings of Fast DDS; gives its domain."""
    with private_domain() as domain, ExitStack() as stack:
        with pytest.MonkeyPatch.context() as patch:
            patch.delenv(FASTDDS_PROFILES[0])
            program = stack.enter_context(start_program('bringup', domain, CALMER))
        program.wait_for_line(READY, START_TIMEOUT)
        yield domain


@pytest.fixture(scope='module')
def robot(shared_in_folder: Callable[..., int]) -> int:
    """Start the default robot once for the tests of this folder; gives its domain."""
    return shared_in_folder(running_robot, Path(__file__).parent, 'robot')


@contextmanager
def command_process(domain: int) -> Iterator[ProcessPoolExecutor]:
    """Start the process of the commands."""
    environment = {'ROS_DOMAIN_ID': str(domain),
                   'AMENT_PREFIX_PATH': os.environ.get('AMENT_PREFIX_PATH', sys.prefix)}
    with ProcessPoolExecutor(1, get_context('spawn'), prepare, (environment,)) as process:
        yield process


@pytest.fixture(scope='module')
def commands(robot: int, shared_in_folder: Callable[..., ProcessPoolExecutor]
             ) -> ProcessPoolExecutor:
    """Give the process that runs the commands of this folder."""
    return shared_in_folder(lambda: command_process(robot), Path(__file__).parent, 'commands')


@pytest.fixture
def ros2(robot: int, commands: ProcessPoolExecutor) -> Ros2:
    """Give a function that runs a command in their process; ``run`` becomes another."""

    def call(*words: str) -> Done:
        if words[:1] == ('run',):
            done = subprocess.run(
                [sys.executable, '-m', 'armsim_ros2', *words], capture_output=True, text=True,
                check=False, env={**os.environ, **ros_environment(robot),
                                  'PYTHONPATH': str(SOURCES), 'PATH': os.defpath})
            return Done(done.returncode, done.stdout, done.stderr)
        patience = SHORT_PATIENCE if NOBODYS in words else PATIENCE
        done = Done(*commands.submit(run_in, os.getcwd(), words, patience).result())
        assert 'Traceback' not in done.err
        return done

    return call


@pytest.fixture
def start(robot: int) -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Give a function that starts a command as a process, with pipes."""
    # Without the folders of a ROS installation, to whose ros2 it would hand over.
    environment = {**os.environ, **ros_environment(robot), 'PYTHONPATH': str(SOURCES),
                   'PATH': os.defpath}
    started: list[subprocess.Popen[str]] = []

    def begin(*words: str) -> subprocess.Popen[str]:
        started.append(subprocess.Popen(
            [sys.executable, '-m', 'armsim_ros2', *words], env=environment, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE))
        return started[-1]

    yield begin
    for process in started:
        process.kill()
        process.communicate()
