# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The last joint states of a topic."""

from contextlib import closing

import pytest
from sensor_msgs.msg import JointState

from armsim_ros.clients.client_node import ClientNode, JointStates
from armsim_ros.errors import SimulationError
from armsim_ros.testing.program import private_domain


@pytest.fixture(scope='module')
def client():
    """Give a node."""
    with private_domain() as domain, ClientNode(domain, 'reader') as node:
        yield node


def test_joint_states_without_a_position_for_each_name_are_dropped(client):
    """
    They neither end a program nor replace what was there.

    robot_state_publisher.cpp ``callbackJointState`` ignores such messages with a message.
    """
    publisher = client.node.create_publisher(JointState, '/leader/joint_states', 10)
    short = JointState(name=['a', 'b'], position=[1.0])
    with closing(JointStates(client, '/leader/joint_states', 'start it')) as states:
        while not publisher.get_subscription_count():
            client.settle()
        publisher.publish(short)
        with pytest.raises(SimulationError, match='2 names and 1 positions was dropped'):
            states.get(1.0)
        publisher.publish(JointState(name=['a', 'b'], position=[1.0, 2.0]))
        assert states.take() is not None
        publisher.publish(short)
        publisher.publish(JointState(name=['a', 'b'], position=[3.0, 4.0]))
        states.take()
        assert states.positions == {'a': 3.0, 'b': 4.0}
