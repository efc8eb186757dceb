# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Servers with a robot of the suite's own, started once for all tests that share it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import os
from pathlib import Path
import shlex
import sys
from typing import Any

from controller_manager_msgs.srv import (
    ConfigureController,
    ListControllers,
    LoadController,
    SwitchController,
    UnloadController,
)
import pytest
import yaml

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.controller_manager import ParameterClient
from armsim_ros.testing.program import private_domain, Program, ros_environment, start_program

sys.path.insert(0, str(Path(__file__).parent))

from controller_bench import Bench, TrajectoryController

ROBOTS = Path(__file__).parent / 'robots'
NAMESPACE = '/bench'
START_TIMEOUT = 60.0
#: All times of these tests are those of messages. A larger factor loses feedback on a loaded
#: machine: its queue holds ten messages.
FAST = 'overrides:={simulation.real_time_factor: 2}'
#: Services of the manager that most tests call.
USED = {
    'list_controllers': ListControllers,
    'load_controller': LoadController,
    'configure_controller': ConfigureController,
    'switch_controller': SwitchController,
    'unload_controller': UnloadController,
}
TRAJECTORY = 'joint_trajectory_controller/JointTrajectoryController'


def pytest_addoption(parser: Any) -> None:
    """Add what only the controllers' part needs."""
    parser.getgroup('conformance').addoption(
        '--spawner-command',
        default=f'{shlex.quote(sys.executable)} -m armsim_ros spawner',
        help="starts the spawner, such as 'ros2 run controller_manager spawner'",
    )


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
                wait_until_up(bench)
                yield bench
        finally:
            if program is not None:
                program.stop(START_TIMEOUT)


def wait_until_up(bench: Bench) -> None:
    """Wait for the manager; a program that does not come up is shown."""
    try:
        services = {bench.name(f'controller_manager/{name}'): kind for name, kind in USED.items()}
        bench.client.connect(services, START_TIMEOUT)
        bench.manager.states()
    except AssertionError as error:
        text = bench.program.text if bench.program is not None else ''
        pytest.exit(f'the server did not come up: {error}\n{text}', 1)


@pytest.fixture(scope='module')
def bench(pytestconfig: pytest.Config, shared_in_folder: Callable[..., Bench]) -> Bench:
    """Give the bench that all tests of the folder share."""
    return shared_in_folder(
        lambda: serve(pytestconfig, 'bench', NAMESPACE, FAST), Path(__file__).parent)


@pytest.fixture
def arm(bench: Bench) -> TrajectoryController:
    """Give the controller whose parameters have their defaults, at rest at 0."""
    return bench.use('arm')


@pytest.fixture
def sampled(bench: Bench) -> TrajectoryController:
    """Give the one whose feedback comes at every update, at rest at 0."""
    return bench.use('sampled')


@pytest.fixture
def fault(bench: Bench) -> Iterator[Callable[..., None]]:
    """Give a function that makes a joint fail, where the server offers such a thing."""
    manager = ParameterClient(bench.client, bench.name('controller_manager'))
    well = {'lag': 0.0, 'bias': 0.0, 'blocked': False}
    changed: set[tuple[str, str]] = set()
    if 'faults.axis_1.bias' not in manager.names():
        pytest.skip('the server has no faults.<joint>.* to make joints fail')

    def make_fail(joint: str, kind: str, value: Any) -> None:
        assert manager.set(f'faults.{joint}.{kind}', value) == ''
        changed.add((joint, kind))

    yield make_fail
    for joint, kind in changed:
        assert manager.set(f'faults.{joint}.{kind}', well[kind]) == ''


@pytest.fixture
def bias(fault: Callable[..., None]) -> Callable[[float], None]:
    """Give a function that shifts the first axis against its commands."""
    return lambda value: fault('axis_1', 'bias', value)


@pytest.fixture
def load(bench: Bench, tmp_path: Path) -> Iterator[Callable[..., bool]]:
    """Give a function that loads a trajectory controller with parameters of its own."""
    loaded: list[str] = []
    manager = ParameterClient(bench.client, bench.name('controller_manager'))

    def load_controller(name: str, kind: str = TRAJECTORY, **parameters: Any) -> bool:
        block = {
            'joints': ['axis_1', 'axis_2'],
            'command_interfaces': ['position'],
            'state_interfaces': ['position', 'velocity'],
        }
        block = {key: value for key, value in {**block, **parameters}.items() if value is not None}
        file = tmp_path / f'{name}.yaml'
        nodes = {bench.name(name): {'ros__parameters': block}}
        file.write_text(yaml.safe_dump(nodes), encoding='utf-8')
        assert manager.set(f'{name}.type', kind) == ''
        assert manager.set(f'{name}.params_file', [str(file)]) == ''
        loaded.append(name)
        return bench.manager.load(name)

    yield load_controller
    states = bench.manager.states()
    for name in loaded:
        if states.get(name) == 'active':
            bench.manager.switch(deactivate=[name])
        if name in states:
            bench.manager.unload(name)
            bench.forget(name)
