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


class Arm:
    """An arm with fingers, what servo knows of its joints, and what it logs."""

    def __init__(self):
        self.kinematics = KinematicModel(load_robot_model(load_robot_settings('panda')))
        self.joints = list(self.kinematics.robot.group('panda_arm').active_joints)
        self.warnings = []
        logger = SimpleNamespace(warning=lambda text, **_: self.warnings.append(text))
        node = SimpleNamespace(poll=self._poll, get_logger=lambda: logger)
        self.states = JointPositions(node, self.kinematics, ('/joint_states',), self.joints)

    def _poll(self, kind, topic, receive, qos):
        self._receive = receive

    def report(self, **fields):
        """Receive joint states."""
        self._receive(JointState(**fields))

    def position(self, name):
        """Return the position of a joint as servo knows it, and its default."""
        index = self.kinematics.index(name)
        return self.states.q[index], self.kinematics.default()[index]


@pytest.fixture
def arm():
    """Return an arm of which nothing is known yet."""
    return Arm()


def test_joints_of_the_group_are_enough(arm):
    """
    Servo needs the joints of its planning group; others keep their default until they come.

    Upstream: servo.cpp, the constructor; current_state_monitor.cpp, waitForCompleteState.
    """
    *most, last = arm.joints
    arm.report(name=most, position=[0.1] * len(most))
    assert arm.states.missing == (last,)
    arm.report(name=[last], position=[0.2])
    assert arm.states.missing == ()
    fingers = [name for name in arm.kinematics.robot.active_joints if name not in arm.joints]
    assert fingers
    for name in fingers:
        known, default = arm.position(name)
        assert known == default


@pytest.mark.parametrize('fields', [
    {'velocity': [0.0] * 7}, {'position': [1.0] * 6}, {'position': [1.0] * 8}],
    ids=['none', 'fewer', 'more'])
def test_a_message_without_a_position_for_each_joint_is_dropped(arm, fields):
    """
    Nothing of it counts, and the log has how many names and positions it had.

    Upstream: current_state_monitor.cpp, jointStateCallback.
    """
    arm.report(name=arm.joints, **fields)
    assert arm.states.missing == tuple(sorted(arm.joints))
    count = len(fields.get('position', ()))
    assert arm.warnings == [f'joint state dropped: 7 names and {count} positions']


def test_a_position_that_is_not_a_number_leaves_its_joint_unknown(arm):
    """Servo goes on waiting for that joint, and takes the others."""
    first, *others = arm.joints
    arm.report(name=arm.joints, position=[float('nan')] + [0.1] * len(others))
    assert arm.states.missing == (first,)
    assert arm.position(others[0])[0] == 0.1
