# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Who hears why a goal was refused."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from rclpy.clock import Clock, ClockType
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from std_msgs.msg import String

from armsim_ros.clients.client_node import LATCHED
from armsim_ros.nodes import qos
from armsim_ros.nodes.simulation.controllers.actions import RejectedGoals


@pytest.fixture
def node(ros_domain_id: int) -> Iterator[Node]:
    """Give a node."""
    context = Context()
    context.init(domain_id=ros_domain_id)
    node = Node('controller', context=context, enable_rosout=False, start_parameter_services=False)
    yield node
    node.destroy_node()
    context.shutdown()


SHORT = QoSProfile(
    depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL, lifespan=Duration(seconds=0.2))


@pytest.mark.parametrize(('profile', 'first'), [(qos.EVENTS, 'old'), (SHORT, 'new')])
def test_who_comes_late_hears_no_old_reason(node: Node, profile: QoSProfile, first: str) -> None:
    """A reason is there for a while, for the client that asks after its goal was refused."""
    rejected = RejectedGoals(node, profile)
    rejected.publish('old')
    Clock(clock_type=ClockType.STEADY_TIME).sleep_for(Duration(seconds=1.0), context=node.context)
    heard: list[str] = []
    node.create_subscription(
        String, '~/rejected_goals', lambda message: heard.append(message.data), LATCHED)

    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    for _ in range(200):
        executor.spin_once(timeout_sec=0.1)
        if heard:
            break
        if profile is SHORT:
            rejected.publish('new')
    executor.shutdown()

    assert heard[0] == first
