# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""One move_group for all tests with controllers that the test plays."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from lone_server import LoneServer
from played_stand import split_robot, Stand, URDF
import pytest


@pytest.fixture
def stand(
    pytestconfig: pytest.Config, tmp_path_factory: pytest.TempPathFactory,
    shared_in_folder: Callable[..., Stand],
) -> Stand:
    """Give the stand with everything as at the start."""
    command = pytestconfig.getoption('server_command', None)
    if command is not None and not command.endswith('armsim_ros bringup'):
        pytest.skip('needs a server of its own with parameters of its own')

    @contextmanager
    def started() -> Iterator[Stand]:
        robot = split_robot(tmp_path_factory.mktemp('robots') / 'split')
        with LoneServer(f'robot:={robot}', URDF) as server:
            yield Stand(server)

    stand = shared_in_folder(started, Path(__file__).parent)
    stand.reset()
    return stand
