# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""One running stack whose world the tests change, put back before each of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
import sys

import pytest

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.testing.program import private_domain, start_program

sys.path.insert(0, str(Path(__file__).parent))

from world_user import READY, START_TIMEOUT, WorldUser


def pytest_configure(config: pytest.Config) -> None:
    """Register the mark."""
    config.addinivalue_line('markers', 'statement(*names): the statements that a test checks')


@contextmanager
def running_stack(folder: Path) -> Iterator[WorldUser]:
    """Run the default robot in its world; the user's files may lie in a folder."""
    with private_domain() as domain, start_program(
        'bringup', domain, 'world:=feeding_place',
        f'overrides:={{simulation.resource_paths: [{folder}]}}',
    ) as program:
        program.wait_for_line(READY, START_TIMEOUT)
        with ClientNode(domain, 'world_user') as client:
            yield WorldUser(client, program, folder)


@pytest.fixture
def stack(
    shared_in_folder: Callable[..., WorldUser], tmp_path_factory: pytest.TempPathFactory
) -> WorldUser:
    """Give the stack that all tests of the folder share."""
    return shared_in_folder(
        lambda: running_stack(tmp_path_factory.mktemp('resources')), Path(__file__).parent)


@pytest.fixture
def world(stack: WorldUser) -> WorldUser:
    """Give the stack as it was at its start, playing."""
    stack.put_back()
    return stack
