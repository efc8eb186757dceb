# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Servers with a robot of the suite's own, started once for all tests that share it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import os
from pathlib import Path
import shlex
import sys
from typing import Any

import pytest

from armsim_ros.testing.client_node import ClientNode
from armsim_ros.testing.controller_manager_client import ControllerManagerClient
from armsim_ros.testing.domain import private_domain, ros_environment
from armsim_ros.testing.program import Program
from armsim_ros.testing.programs import start_program

sys.path.insert(0, str(Path(__file__).parent))

from controller_bench import Bench, TrajectoryController

ROBOTS = Path(__file__).parent / 'robots'
NAMESPACE = '/bench'


def pytest_configure(config: pytest.Config) -> None:
    """Register the marks."""
    config.addinivalue_line('markers', 'statement(*names): the statements that a test checks')
    config.addinivalue_line('markers', 'upstream(*names): the upstream tests that it re-enacts')


@contextmanager
def serve(config: Any, robot: str, namespace: str, *arguments: str) -> Iterator[Bench]:
    """
    Start the server with a robot of the suite, or join the one that runs already.

    ``--server-command`` may hold ``{robot}`` for the folder with URDF and YAML files.
    """
    command = config.getoption('server_command', None)
    folder = ROBOTS / robot
    with private_domain() as leased:
        if command is None or command.endswith('armsim_ros bringup'):
            domain = leased
            program = start_program('simulation', domain, f'robot:={folder}', *arguments)
        elif command:
            domain = leased
            words = shlex.split(command.replace('{robot}', str(folder)))
            program = Program(words, environment=ros_environment(domain))
        else:
            domain = int(os.environ.get('ROS_DOMAIN_ID', '0'))
            program = None
        try:
            with ClientNode(domain, f'conformance_{robot}') as client:
                bench = Bench(domain, namespace, client, program)
                ControllerManagerClient(client, f'{namespace}/controller_manager')
                bench.manager.states()
                yield bench
        finally:
            if program is not None:
                program.stop()


@pytest.fixture(scope='session')
def bench(pytestconfig: pytest.Config) -> Iterator[Bench]:
    """Run the bench for all tests."""
    with serve(pytestconfig, 'bench', NAMESPACE) as running:
        yield running


@pytest.fixture
def arm(bench: Bench) -> TrajectoryController:
    """Give the controller whose parameters have their defaults, at rest at 0."""
    return bench.use('arm')


@pytest.fixture
def sampled(bench: Bench) -> TrajectoryController:
    """Give the one whose feedback comes at every update, at rest at 0."""
    return bench.use('sampled')
