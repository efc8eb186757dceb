# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""crisp-python as it is on the package index drives the compliant controllers of a Panda."""

from pathlib import Path
import subprocess
import sys

import pytest

from armsim_ros.testing.program import private_domain, ros_environment
from armsim_ros.testing.robot_user import running_robot

pytest.importorskip('crisp_py.robot.robot', reason='crisp-python is not installed')

PROGRAM = Path(__file__).with_name('yield_and_press.py')
FILE = Path(__file__).parents[3] / 'examples' / 'crisp_panda.yaml'
INACTIVE = ('joint_trajectory_controller', 'cartesian_impedance_controller',
            'joint_impedance_controller')


def spawn(domain, *arguments):
    """Run the spawner with the example's file."""
    subprocess.run([sys.executable, '-m', 'armsim_ros', 'spawner', *arguments, '-p', str(FILE)],
                   env=ros_environment(domain), timeout=120, check=True)


def test_it_homes_moves_and_yields():
    """Home, switches, gains of its own file, targets of pose, joints, stiffness and wrench."""
    with private_domain() as domain, running_robot(
            'robot:=panda', namespace='', domain=domain):
        spawn(domain, *INACTIVE, '--inactive')
        spawn(domain, 'pose_broadcaster', 'twist_broadcaster')
        done = subprocess.run([sys.executable, PROGRAM], capture_output=True, text=True,
                              env=ros_environment(domain), timeout=180)
        assert done.returncode == 0, done.stderr
