# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What controllers take of a burst of commands."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace

import pytest
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Float64MultiArray

from armsim_ros.nodes.simulation.controllers.state_topics import Commands


@pytest.fixture
def node(ros_domain_id: int) -> Iterator[Node]:
    """Give a node."""
    context = Context()
    context.init(domain_id=ros_domain_id)
    node = Node('forward', context=context, enable_rosout=False, start_parameter_services=False)
    yield node
    node.destroy_node()
    context.shutdown()


def test_only_the_newest_command_waits(node: Node) -> None:
    """
    A controller that is late follows the newest command, not the ones before it.

    Upstream: forward_controllers_base.cpp, on_configure; the system default of Fast DDS has a
    depth of 1.
    """
    taken: list[list[float]] = []
    controller = SimpleNamespace(
        single=False, receive=lambda values: taken.append(list(values)))
    topic = Commands(node, controller)  # type: ignore[arg-type]
    publisher = node.create_publisher(Float64MultiArray, '~/commands', 10)
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    while not publisher.get_subscription_count():
        executor.spin_once(timeout_sec=0.01)
    for value in range(5):
        publisher.publish(Float64MultiArray(data=[float(value)]))
    while [4.0] not in taken:
        executor.spin_once(timeout_sec=5.0)
    assert len(taken) <= 2, taken  # one may have been on its way into the reader
    executor.shutdown()
    del topic
