# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which joint states servo waits for."""

from types import SimpleNamespace

import pytest
from sensor_msgs.msg import JointState

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.loading import load_robot_model
from armsim_ros.nodes.servo.inputs import JointPositions


@pytest.fixture
def kinematics():
    """Return an arm with fingers."""
    return KinematicModel(load_robot_model(load_robot_settings('panda')))


def test_joints_of_the_group_are_enough(kinematics):
    """
    Servo needs the joints of its planning group; others keep their default until they come.

    Upstream: servo.cpp, the constructor; current_state_monitor.cpp, waitForCompleteState.
    """
    received = []
    node = SimpleNamespace(poll=lambda kind, topic, receive, qos: received.append(receive))
    joints = kinematics.robot.group('panda_arm').active_joints
    states = JointPositions(node, kinematics, ('/joint_states',), joints)
    received[0](JointState(name=list(joints[:-1]), position=[0.1] * (len(joints) - 1)))
    assert states.missing == (joints[-1],)
    received[0](JointState(name=[joints[-1]], position=[0.2]))
    assert states.missing == ()
    fingers = [name for name in kinematics.robot.active_joints if name not in joints]
    default = kinematics.default()
    assert fingers
    assert all(states.q[kinematics.index(name)] == default[kinematics.index(name)]
               for name in fingers)
