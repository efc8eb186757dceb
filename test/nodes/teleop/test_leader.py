# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A leader arm, known by its joint states."""

from contextlib import closing
import math

import pytest
from sensor_msgs.msg import JointState

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.teleop.leader import Leader


@pytest.fixture
def driver():
    """Give a publisher of joint states, repeated, and the node that subscribes."""
    with ClientNode(name='leader_driver') as node, ClientNode(name='follower') as client:
        message = JointState(name=['b', 'finger', 'a'], position=[0.2, 0.0, 0.1])
        publisher = node.node.create_publisher(JointState, '/leader', 10)
        node.node.create_timer(0.02, lambda: publisher.publish(message))
        yield message, client


def test_joints_are_found_by_name(driver):
    """In whatever order they are; others are left out."""
    _, client = driver
    with closing(Leader(client, '/leader', ('a', 'b'), 20.0)) as leader:
        assert leader.positions == {'a': 0.1, 'b': 0.2}


def test_positions_that_are_not_finite_count_as_silence(driver):
    """The arm holds then."""
    message, client = driver
    message.position[2] = math.nan
    with closing(Leader(client, '/leader', ('a', 'b'), 20.0)) as leader:
        assert leader.positions is None


def test_missing_joints_are_named(driver):
    """With those that there are."""
    _, client = driver
    with pytest.raises(ArmsimError, match=r"'/leader' has no c, d, only b, finger, a; .* name"):
        Leader(client, '/leader', ('a', 'c', 'd'), 20.0)
