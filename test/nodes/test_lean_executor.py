# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""LeanExecutor: rclpy/rclpy/event_handler.py has the warnings that it checks on the side."""

import threading

import pytest
import rclpy
from rclpy.context import Context
from rclpy.event_handler import EventHandler, PublisherEventCallbacks
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import String

from armsim_ros.nodes.lean_executor import LeanExecutor

LATCHED = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)


@pytest.fixture
def nodes(ros_domain_id):
    """Return two nodes that an executor runs, and the executor."""
    context = Context()
    rclpy.init(args=[], context=context, domain_id=ros_domain_id,
               signal_handler_options=SignalHandlerOptions.NO)
    executor = LeanExecutor(context=context)
    made = [rclpy.create_node(name, context=context) for name in ('first', 'second')]
    for node in made:
        executor.add_node(node)
    yield *made, executor
    executor.shutdown(0.0)
    for node in made:
        node.destroy_node()
    context.try_shutdown()


def spin_until(executor, condition):
    """Serve until a condition holds."""
    for _ in range(100):
        if condition():
            return
        executor.spin_once(0.1)
    raise AssertionError('it never came')


def test_incompatible_endpoints_are_reported(nodes, capfd):
    """A subscription that asks for more than is offered is warned of, as with rclpy's executor."""
    first, second, executor = nodes
    first.create_publisher(String, 'text', 1)
    second.create_subscription(String, 'text', lambda _: None, LATCHED)
    seen = []

    def warned():
        seen.append(capfd.readouterr().err)
        return "New publisher discovered on topic 'text'" in ''.join(seen)

    spin_until(executor, warned)


def test_messages_do_not_wait_for_warnings(nodes):
    """No event of an incompatible endpoint is in the wait set; all else is."""
    first, second, executor = nodes
    first.create_publisher(String, 'text', 1)
    subscription = second.create_subscription(String, 'text', lambda _: None, 1)
    events = [each for node in (first, second) for each in node.waitables]
    assert events
    assert all(isinstance(each, EventHandler) for each in events)
    assert not any(map(executor.can_execute, events))
    assert executor.can_execute(subscription)


def test_a_callback_of_a_match_runs_at_once(nodes):
    """An event that somebody asked for wakes the executor."""
    first, second, executor = nodes
    matched = threading.Event()
    first.create_publisher(
        String, 'text', 1,
        event_callbacks=PublisherEventCallbacks(matched=lambda _: matched.set()))
    wanted = next(each for each in first.waitables if each.event_type.name.endswith('MATCHED'))
    assert executor.can_execute(wanted)
    second.create_subscription(String, 'text', lambda _: None, 1)
    spin_until(executor, matched.is_set)
