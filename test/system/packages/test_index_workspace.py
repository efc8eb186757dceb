# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A workspace from the package index, as it is: launch files and Python programs of a thesis.

pip install --no-deps 7dof-pendant==0.1.4 urdf-parser-py lxml
"""

from contextlib import contextmanager
import json
from pathlib import Path

import pytest
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from trajectory_msgs.msg import JointTrajectory

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.motion import SUCCESS
from armsim_ros.testing.program import private_domain, start_program
from armsim_ros.testing.robot_user import RobotUser

pendant = pytest.importorskip('pendant7dof', reason='7dof-pendant is not installed')
pytest.importorskip('urdf_parser_py', reason='urdf-parser-py is not installed')

SOURCES = Path(pendant.__file__).parent / 'workspace/src'
LAUNCH = SOURCES / 'arm_bot/launch/pendant_backend.launch.py'
STROKES = {'canvas': {'width': 60, 'height': 60}, 'strokes': [{'id': 0, 'points': [
    {'x': 25.0 + x, 'y': 30.0, 't': 0.1 * x} for x in range(8)]}]}


@contextmanager
def backend(mode):
    """Give a user of the arm, and a publisher of drawings, once its nodes have moved the arm."""
    with (
        private_domain() as domain,
        start_program('launch', domain, str(LAUNCH), f'mode:={mode}') as program,
        ClientNode(domain, 'user') as client,
    ):
        strokes = client.node.create_publisher(String, '/drawing/strokes', 10)
        program.wait_for_line('go_to_start: done', 60.0)
        yield RobotUser(client, program, ''), strokes
        assert 'process has died' not in program.text


def test_its_drawing_moves_the_arm():
    """Its Gazebo stack starts with all nodes; the arm ends where its drawing does."""
    with backend('gazebo') as (user, strokes):
        drawn = user.client.collect('/arm_controller/joint_trajectory', JointTrajectory)
        strokes.publish(String(data=json.dumps(STROKES)))
        plan = drawn.wait_for(lambda message: len(message.points) > 3)
        end = dict(zip(plan.joint_names, plan.points[-1].positions, strict=True))
        states = user.client.collect('/joint_states', JointState)
        states.wait_for(lambda message: all(
            abs(value - end[name]) < 1e-3
            for name, value in zip(message.name, message.position, strict=True)), 60.0)


def test_its_moveit_stack_plans():
    """A named state of its SRDF is planned and reached with its demo.launch.py."""
    with backend('moveit') as (user, _):
        user.program.wait_for_line('You can start planning now!', 60.0)
        user.wait_until_still()
        bend = user.move_group.named_states()['arm', 'bend']
        assert user.move_group.move('arm', bend).error_code.val == SUCCESS
        assert user.distance(bend) < 0.005
