# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A server under test, ours or the original, and the table of what it was seen to do.

Nothing here or below imports the planner or the simulation: only ROS interfaces are used.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
import os
from pathlib import Path
import re
import shlex
import sys
from tempfile import TemporaryDirectory
from typing import Any

from faster import FASTER
import pytest

from armsim_ros.testing.program import private_domain, Program, ros_environment

sys.path.append(str(Path(__file__).parent))

from report import ConformanceReport

OURS = f'{shlex.quote(sys.executable)} -m armsim_ros bringup'
READY = 'You can start planning now!'
START_TIMEOUT = 60.0


def pytest_addoption(parser: Any) -> None:
    """Add what it takes to run against another server."""
    group = parser.getgroup('conformance')
    group.addoption('--conformance-report', metavar='FILE', help='write the tables to this file')
    group.addoption(
        '--server-command',
        default=OURS,
        help="starts the server; '' for one that runs already, in the domain of ROS_DOMAIN_ID",
    )
    group.addoption('--server-ready', default=READY, help='regular expression of its ready line')
    group.addoption('--server-namespace', default='', help='namespace of move_group')
    group.addoption('--fuzz', type=int, default=30, help='random messages of each kind')


def pytest_configure(config: pytest.Config) -> None:
    """Register the mark and, where wanted, the report."""
    config.addinivalue_line('markers', 'statement(*names): the statements that a test checks')
    path = config.getoption('conformance_report', None)
    if path:
        config.pluginmanager.register(ConformanceReport(Path(path)), 'conformance-report')


@dataclass(frozen=True)
class Server:
    """
    The server under test.

    :param namespace: of move_group, without a slash at the end.
    :param program: None where the server ran before.
    :param home: its ROS_HOME, where that is known.
    """

    domain: int
    namespace: str
    program: Program | None
    home: Path | None = None

    def name(self, relative: str) -> str:
        """Return the full name of one of move_group's endpoints."""
        return f'{self.namespace}/{relative}'


@contextmanager
def running_server(pytestconfig: pytest.Config) -> Iterator[Server]:
    """Run the server that the command line names."""
    command = shlex.split(pytestconfig.getoption('server_command', OURS))
    namespace = pytestconfig.getoption('server_namespace', '').rstrip('/')
    if not command:
        yield Server(int(os.environ.get('ROS_DOMAIN_ID', '0')), namespace, None)
        return
    if command == shlex.split(OURS):
        command.append('scene_from_world:=false')  # the tests bring their own objects
        command.append(FASTER)
    with (
        TemporaryDirectory() as home,
        private_domain() as domain,
        Program(command, environment=ros_environment(domain) | {'ROS_HOME': home}) as program,
    ):
        ready = pytestconfig.getoption('server_ready', re.escape(READY))
        program.wait_for_line(ready, START_TIMEOUT)
        yield Server(domain, namespace, program, Path(home))


@pytest.fixture(scope='module')
def server(pytestconfig: pytest.Config, shared_in_folder: Callable[..., Server]) -> Server:
    """Start the server once for all tests of move_group."""
    return shared_in_folder(
        lambda: running_server(pytestconfig), Path(__file__).parent / 'move_group', 'server')


@pytest.fixture
def own_server(pytestconfig: pytest.Config) -> Iterator[Server]:
    """Start a server for one test, which may leave it in any state."""
    with running_server(pytestconfig) as server:
        yield server
