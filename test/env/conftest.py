# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Environments for tests, from files that are read once."""

import pytest

from armsim_ros.env import ArmEnv
from armsim_ros.model.cell_loading import load_cell

RANGES = {
    'objects': {'cube': {
        'xyz': ((0.1, 0.2, 1.04), (0.2, 0.3, 1.04)), 'rpy': ((0, 0, -1), (0, 0, 1)),
        'mass': (0.1, 0.5), 'friction': (0.3, 1.0), 'color': ((0, 0, 0), (1, 1, 1)),
    }},
    'joints': {'joint_1': (-0.3, 0.3)},
}


def pytest_configure(config):
    """Register the mark that names a statement."""
    config.addinivalue_line('markers', 'statement(*names): the statements that a test checks')


@pytest.fixture(scope='session')
def cell():
    """Return the checked files of the default robot."""
    return load_cell('sunday')


@pytest.fixture
def new_env(cell):
    """Return a function that makes an environment with ranges for cube and joint_1."""
    made = []

    def make(**words):
        made.append(ArmEnv(words.pop('robot', cell), **{'randomize': RANGES, **words}))
        return made[-1]

    yield make
    for env in made:
        env.close()
