# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a topic's controller is said to do, told by the manager's and the actions' messages."""

import time
from types import SimpleNamespace

from action_msgs.msg import GoalStatus, GoalStatusArray
from controller_manager_msgs.msg import ControllerManagerActivity, NamedLifecycleState
from lifecycle_msgs.msg import State
import pytest
import rclpy
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions

from armsim_ros.nodes import qos
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.nodes.servo.output import ActionWatch, ControllerWatch


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


class Servers:
    """Servers of an action, and the node that watches it."""

    def __init__(self, node):
        self._node = node
        self.watch = ActionWatch(node, 'move_action')
        self._wait = node.waiter(self.watch.subscription)

    def start(self):
        """Return the publisher of a new server."""
        return self._node.create_publisher(
            GoalStatusArray, 'move_action/_action/status', qos.LATCHED)

    def report(self, publisher, *states):
        """Publish the states of goals, and read them."""
        publisher.publish(GoalStatusArray(
            status_list=[GoalStatus(status=state) for state in states]))
        assert self._wait(30.0)
        self._node.catch_up(self.watch.subscription)

    def kill(self, publisher):
        """Take a server away without another message."""
        self._node.destroy_publisher(publisher)

    def is_idle(self):
        """Return whether the action stops being busy; the graph learns of a death in time."""
        deadline = time.monotonic() + 30.0
        while self.watch.busy and time.monotonic() < deadline:
            pass
        return not self.watch.busy


@pytest.fixture
def servers():
    """Return servers of which none is there yet."""
    context = Context()
    rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
    node = PollingNode('watching', context=context)
    yield Servers(node)
    node.destroy_node()
    context.shutdown()


def test_an_action_is_busy_while_a_goal_runs(servers):
    """From the message that a goal executes until the one that none does."""
    server = servers.start()
    assert not servers.watch.busy
    servers.report(server, GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_EXECUTING)
    assert servers.watch.busy
    servers.report(server, GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_SUCCEEDED)
    assert not servers.watch.busy


def test_a_goal_ends_with_its_server(servers):
    """A server that dies publishes no end, and the next one nothing before its first goal."""
    server = servers.start()
    servers.report(server, GoalStatus.STATUS_EXECUTING)
    assert servers.watch.busy
    servers.kill(server)
    server = servers.start()
    assert servers.is_idle()
    servers.report(server, GoalStatus.STATUS_EXECUTING)
    assert servers.watch.busy


def test_a_publisher_that_the_graph_knows_late_has_its_goal(servers, monkeypatch):
    """It runs, too, where nothing has asked for it until then."""
    server = servers.start()
    with monkeypatch.context() as late:
        late.setattr(servers.watch, '_present', set)
        late.setattr('armsim_ros.nodes.servo.output._FIRST', 0.0)
        servers.report(server, GoalStatus.STATUS_EXECUTING)
    assert servers.watch.busy
