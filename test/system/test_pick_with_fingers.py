# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The example that picks a cube with two fingers, as a user runs it."""

from pathlib import Path
import subprocess
import sys

import pytest

from armsim_ros.testing.domain import private_domain, ros_environment
from armsim_ros.testing.robot_user import running_robot

EXAMPLE = Path(__file__).parents[2] / 'examples' / 'pick_with_fingers.py'


@pytest.fixture(scope='module')
def pick():
    """Return a function that runs the example beside ROBOT on a floor."""
    with private_domain() as domain, running_robot(
        'robot:=ROBOT', 'world:=empty', namespace='/ROBOT', domain=domain
    ):
        yield lambda *options: subprocess.run(
            [sys.executable, str(EXAMPLE), *options, '--patience', '60', '--timeout', '120'],
            env=ros_environment(domain), capture_output=True, text=True, check=False,
        )


def test_a_cube_is_picked_carried_and_put_down(pick):
    """Each step is printed; the cube ends where it should."""
    run = pick('--from', '0.42', '0.1', '0.3', '--to', '0.35', '-0.25', '0')
    assert run.returncode == 0, run.stdout + run.stderr
    for step in ('above the cube', 'fingers closed', 'lifted', 'carried', 'released', 'back'):
        assert step in run.stdout.splitlines()
    assert 'from where it should' in run.stdout


def test_a_miss_has_a_reason(pick):
    """Out of reach: it says so, and that it has missed."""
    run = pick('--from', '1.5', '0', '0')
    assert run.returncode == 1
    assert run.stderr.startswith('missed: above the cube: ')
