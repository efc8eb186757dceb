# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""One simulation of the default robot for all modules here, each of which leaves it as it was."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.testing.program import private_domain, Program, start_program


@dataclass(frozen=True)
class Running:
    """A simulation, its domain, and a node beside it."""

    domain: int
    program: Program
    client: ClientNode


@contextmanager
def running_simulation() -> Iterator[Running]:
    """Run the simulation for the time of the context."""
    with (
        private_domain() as domain,
        start_program('simulation', domain) as program,
        ClientNode(domain) as client,
    ):
        yield Running(domain, program, client)


@pytest.fixture(scope='module')
def running(shared_in_folder: Callable[..., Running]) -> Running:
    """Give the simulation that the modules share."""
    return shared_in_folder(running_simulation, Path(__file__).parent)


@pytest.fixture(scope='module')
def ros_domain(running: Running) -> int:
    """Give the simulation's domain."""
    return running.domain


@pytest.fixture(scope='module')
def client(running: Running) -> ClientNode:
    """Give a node on that domain."""
    return running.client


@pytest.fixture(scope='module')
def simulation(running: Running) -> Program:
    """Give the simulation itself."""
    return running.program
