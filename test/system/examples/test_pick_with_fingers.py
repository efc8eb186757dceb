# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The example that picks a cube with two fingers, as a user runs it."""

from contextlib import contextmanager
from pathlib import Path
import subprocess
import sys

from faster import LITTLE_FASTER
import pytest

from armsim_ros.testing.program import private_domain, ros_environment
from armsim_ros.testing.robot_user import running_robot

EXAMPLE = Path(__file__).parents[3] / 'examples' / 'pick_with_fingers.py'


PLACES = ('--from', '0.42', '0.1', '0.3', '--to', '0.42', '-0.1', '0')
STEPS = ('above the cube', 'fingers closed', 'lifted', 'carried', 'released', 'back')


@contextmanager
def running_example(robot, namespace=''):
    """Yield a function that runs the example beside a robot on a floor."""
    with private_domain() as domain, running_robot(
        f'robot:={robot}', 'world:=empty', LITTLE_FASTER, namespace=namespace, domain=domain
    ):
        yield lambda *options: subprocess.run(
            [sys.executable, str(EXAMPLE), '--robot', robot, *options, '--patience', '60',
             '--timeout', '120'],
            env=ros_environment(domain), capture_output=True, text=True, check=False,
        )


@pytest.fixture(scope='module')
def pick():
    """Run the example with ROBOT."""
    with running_example('ROBOT', '/ROBOT') as run:
        yield run


def test_a_cube_is_picked_carried_and_put_down(pick):
    """Each step is printed; the cube ends where it should."""
    assert_done(pick(*PLACES))


def test_a_miss_has_a_reason(pick):
    """Out of reach: it says so, and that it has missed."""
    run = pick('--from', '1.5', '0', '0')
    assert run.returncode == 1
    assert run.stderr.startswith('missed: above the cube: ')


def test_a_gripper_controller_holds_the_cube():
    """The panda's hand is driven by GripperCommand: it stalls on the cube and keeps pressing."""
    with running_example('panda') as run:
        assert_done(run(*PLACES))


def assert_done(run):
    """Check that all steps were done, and that the cube lies where it should."""
    assert run.returncode == 0, run.stdout + run.stderr
    assert set(STEPS) <= set(run.stdout.splitlines())
    assert 'mm from its target' in run.stdout
