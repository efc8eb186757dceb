# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
crisp-python as it is on the package index, beside an arm whose controller has the name it expects.

pip install --no-deps crisp-python==3.6.0 scipy: its limit of numpy is not that of this package.
"""

from pathlib import Path
import shutil
import subprocess
import sys

from moveit_msgs.srv import GetPositionFK
import pytest

from armsim_ros.resources import find_robot
from armsim_ros.testing.program import private_domain, ros_environment
from armsim_ros.testing.robot_user import running_robot

pytest.importorskip('crisp_py.robot.robot', reason='crisp-python is not installed')

PROGRAM = Path(__file__).with_name('move_and_report.py')
BENT = (0.0, 0.4569, 0.4905, -0.5519, 1.57, 0.0)


@pytest.fixture
def folder(tmp_path):
    """Return the default robot with the name of the controller that crisp_py has built in."""
    folder = tmp_path / 'sunday'
    shutil.copytree(find_robot('sunday'), folder)
    for file in folder.glob('*.yaml'):
        text = file.read_text()
        file.write_text(text.replace('arm_joint_controller', 'joint_trajectory_controller'))
    return folder


def test_it_moves_the_arm_and_knows_where_the_tool_is(folder):
    """Joint states, TF, controllers, parameters and a trajectory, as its Robot uses them."""
    with private_domain() as domain, running_robot(
            f'robot:={folder}', namespace='/sunday', domain=domain) as robot:
        done = subprocess.run(
            [sys.executable, PROGRAM, *map(str, BENT)], capture_output=True, text=True,
            env=ros_environment(domain), timeout=120)
        assert done.returncode == 0, done.stderr
        numbers = [float(word) for word in done.stdout.split()]
        assert numbers[:6] == pytest.approx(BENT, abs=5e-3)
        request = GetPositionFK.Request(fk_link_names=['link_6'])
        request.header.frame_id = 'base_link'
        request.robot_state.is_diff = True
        (expected,) = robot.client.call('/compute_fk', GetPositionFK, request).pose_stamped
        position = expected.pose.position
        assert numbers[6:] == pytest.approx((position.x, position.y, position.z), abs=2e-3)
