# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a topic's controller is said to do, told by the manager's messages."""

from types import SimpleNamespace

from controller_manager_msgs.msg import ControllerManagerActivity, NamedLifecycleState
from lifecycle_msgs.msg import State
import pytest

from armsim_ros.nodes.servo.output import ControllerWatch


@pytest.fixture
def told():
    """Return a function that gives what is wrong with a topic's controller, once it is told."""
    def told(topic, *messages):
        heard = {}
        node = SimpleNamespace(
            poll=lambda *arguments: None,
            create_subscription=lambda kind, name, receive, profile: heard.update({name: receive}))
        watch = ControllerWatch(node, topic, ())
        manager = f'{watch.controller.rpartition("/")[0]}/controller_manager/activity'
        for states in messages:
            heard[manager](ControllerManagerActivity(controllers=[
                NamedLifecycleState(name=name, state=State(label=label))
                for name, label in states.items()]))
        return watch.inactive

    return told


def test_a_controller_that_is_not_active_is_named(told):
    """Inactive, and unloaded after it had been there."""
    topic = '/bot/arm/joint_trajectory'
    assert told(topic) == ''
    assert told(topic, {'arm': 'active'}) == ''
    assert told(topic, {'arm': 'inactive'}) == "controller '/bot/arm' is inactive"
    assert told(topic, {'arm': 'active'}, {}) == "controller '/bot/arm' is not loaded"


@pytest.mark.parametrize('topic', ['/joint_trajectory', '/safety_filter/joint_trajectory_in'])
def test_a_node_before_the_controller_may_take_the_commands(told, topic):
    """
    A topic that is no controller's is streamed to.

    Upstream: servo_node.cpp publishes, whoever subscribes.
    """
    assert told(topic, {'arm': 'active'}, {'arm': 'inactive'}) == ''
