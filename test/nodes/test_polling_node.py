# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A node whose topics wake nobody but who waits for them."""

import gc

import pytest
import rclpy
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import Int32

from armsim_ros.nodes import qos
from armsim_ros.nodes.polling_node import OutsideExecutors, PollingNode


@pytest.fixture
def node():
    """Return a node in the domain of the tests."""
    context = Context()
    rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
    made = PollingNode('polling', context=context)
    yield made
    made.destroy_node()
    context.shutdown()


def test_waits_for_a_message(node):
    """It tells of a message that was not yet taken; then, and before, the time is over."""
    taken = []
    awaited = node.poll(Int32, 'numbers', lambda message: taken.append(message.data),
                        qos.LATCHED)
    other = node.poll(Int32, 'others', taken.append, qos.LATCHED)
    wait = node.waiter(awaited)
    assert not wait(0.0)
    publishers = {name: node.create_publisher(Int32, name, qos.LATCHED)
                  for name in ('numbers', 'others')}
    publishers['others'].publish(Int32(data=1))
    publishers['numbers'].publish(Int32(data=2))
    assert wait(30.0)
    assert wait(30.0)
    node.catch_up(awaited)
    assert taken == [2]
    assert not wait(0.0)
    assert other.handle


def test_endpoints_that_are_gone_are_forgotten(node):
    """A program may make and destroy them for as long as it runs."""
    groups = [node.default_callback_group, OutsideExecutors()]
    before = [len(group.entities) for group in groups]
    for _ in range(3):
        for group in groups:
            node.destroy_publisher(node.create_publisher(
                Int32, 'numbers', 1, callback_group=group))
            node.destroy_subscription(node.create_subscription(
                Int32, 'numbers', lambda _: None, 1, callback_group=group))
    gc.collect()
    assert [len(group.entities) for group in groups] == before
