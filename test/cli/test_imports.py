# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What programs load, which decides how soon they start and how much memory they take."""

import subprocess
import sys

import pytest

PLANNING = {'pinocchio', 'coal', 'ompl', 'toppra'}
PHYSICS = {'mujoco'}
#: Rooms that programs beside the two large ones do not need.
CORE = {f'armsim_ros.{room}' for room in (
    'config', 'control', 'execution', 'kinematics', 'servo', 'sim')}


@pytest.mark.parametrize(('module', 'unwanted'), [
    ('nodes.bringup.main', PLANNING | PHYSICS | CORE | {'rclpy', 'numpy', 'yaml'}),
    ('nodes.upstream.main', PLANNING | PHYSICS | CORE | {'rclpy', 'numpy', 'yaml'}),
    ('nodes.upstream.spawner', PLANNING | PHYSICS | {'rclpy.action', 'numpy', 'pydantic'}),
    ('nodes.verbs.state', PLANNING | PHYSICS | CORE | {'rclpy.action', 'pydantic'}),
    ('nodes.verbs.stop', PLANNING | PHYSICS | CORE | {'rclpy.action', 'pydantic'}),
    ('nodes.bridge.program', PLANNING | PHYSICS | CORE | {'armsim_ros.planning', 'pydantic'}),
    ('nodes.web.program', PLANNING | PHYSICS | CORE),
    ('nodes.camera.program', PLANNING | PHYSICS | {'armsim_ros.control', 'armsim_ros.planning'}),
    ('nodes.servo.program', PHYSICS | {'ompl', 'toppra'}),
    ('nodes.simulation.program', PLANNING),
    ('launch.main', PLANNING | PHYSICS | CORE | {'rclpy', 'numpy', 'pydantic'}),
])
def test_a_program_loads_no_more_than_it_needs(module, unwanted):
    """Physics is loaded by the simulation, planning by move_group, neither by the others."""
    code = f"import sys, armsim_ros.{module}; print(*sys.modules, sep='\\n')"
    loaded = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True,
                            check=True).stdout.split()
    assert not unwanted & set(loaded)


SCAN = """
import importlib.metadata
import sys

def refuse(*_arguments):
    sys.exit('metadata were read')

importlib.metadata.PathDistribution.read_text = refuse
from armsim_ros.cli.main import main
sys.exit(main(['move_group', 'overrides:={planning_attempts: none}']))
"""


def test_a_program_reads_the_metadata_of_no_package():
    """Pydantic would read those of all, for plugins, and a start would take a twelfth longer."""
    ended = subprocess.run(
        [sys.executable, '-c', SCAN], capture_output=True, text=True, check=False)
    assert "'planning_attempts'" in ended.stderr
    assert 'metadata were read' not in ended.stderr
