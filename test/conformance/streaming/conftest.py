# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""One arm with forward controllers, servo_node and move_group, for all tests of the folder."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
import shutil
import sys

import pytest
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.resources import share_folder
from armsim_ros.testing.program import private_domain, start_program

sys.path.insert(0, str(Path(__file__).parent))

from streaming_bench import FORWARD_CONTROLLERS, SIMULATION, Streamed

START_TIMEOUT = 90.0


def pytest_configure(config: pytest.Config) -> None:
    """Register the mark."""
    config.addinivalue_line('markers', 'statement(*names): the statements that a test checks')


@contextmanager
def running(folder: Path) -> Iterator[Streamed]:
    """Run the stack with the forward controllers beside the robot's own."""
    shutil.copytree(share_folder('armsim_ros') / 'config/sunday', folder)
    (folder / 'servo.yaml').unlink()  # the statements are about servo's defaults
    (folder / 'forward_controllers.yaml').write_text(FORWARD_CONTROLLERS, encoding='utf-8')
    with (folder / 'simulation.yaml').open('a', encoding='utf-8') as file:
        file.write(SIMULATION)
    with private_domain() as domain:
        program = start_program(
            'bringup', domain, 'robot:=sunday', f'config:={folder}', 'servo:=true',
            'scene_from_world:=false',
        )
        try:
            program.wait_for_line('Servo initialized successfully', START_TIMEOUT)
            program.wait_for_line('You can start planning now', START_TIMEOUT)
            with ClientNode(domain, 'streaming_user') as client:
                # Where the start took long, simulated time is behind the wall clock.
                client.node.set_parameters([Parameter('use_sim_time', value=True)])
                with closing(client.collect('/clock', Clock)) as clock:
                    clock.wait(2)
                yield Streamed(domain, program, client)
        finally:
            program.stop()


@pytest.fixture(scope='module')
def stack(
    shared_in_folder: Callable[..., Streamed], tmp_path_factory: pytest.TempPathFactory
) -> Streamed:
    """Give the stack that all tests of the folder share."""
    return shared_in_folder(
        lambda: running(tmp_path_factory.mktemp('streaming') / 'sunday'), Path(__file__).parent)


@pytest.fixture
def arm(stack: Streamed) -> Streamed:
    """Give the stack with the trajectory controller active and the arm at its place."""
    stack.begin()
    return stack


@pytest.fixture
def references(arm: Streamed) -> Iterator[None]:
    """Record the references of the trajectory controller."""
    with arm.references():
        yield


@pytest.fixture(scope='module')
def statuses(stack: Streamed) -> Iterator[None]:
    """Record what servo reports."""
    with stack.statuses():
        yield
