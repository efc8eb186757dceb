# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When the action server of a controller passes a goal on."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from control_msgs.action import FollowJointTrajectory
import pytest
from rclpy.action import ActionClient
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from armsim_ros.nodes.simulation.controllers.actions import GoalServer
from armsim_ros.nodes.simulation.dispatcher import Dispatcher


class HalfDiscovered(Node):
    """A node that has discovered the request writers of clients, and their readers later."""

    readers = False
    asked = 0

    def count_clients(self, service_name: str) -> int:
        """Return the number of readers; ``asked`` counts the calls."""
        self.asked += 1
        return super().count_clients(service_name) if self.readers else 0


class Recorder(GoalServer):
    """Refuses each goal and notes it."""

    def __init__(self, *arguments: Any) -> None:
        self.goals: list[Any] = []
        super().__init__(*arguments)

    def _send(self, request: Any) -> None:
        self.goals.append(request)

    _cancel_goal = _result = _aborted = None


@pytest.fixture
def node(ros_domain_id: int) -> Iterator[HalfDiscovered]:
    """Give a node whose clients are half discovered."""
    context = Context()
    context.init(domain_id=ros_domain_id)
    node = HalfDiscovered(
        'arm', context=context, enable_rosout=False, start_parameter_services=False)
    yield node
    node.destroy_node()
    context.shutdown()


def test_a_goal_waits_until_its_client_can_be_answered(node: HalfDiscovered) -> None:
    """
    It is not passed on while the reader of its answers is unknown, and is as soon as it is known.

    The middleware drops an answer whose reader it does not know
    (rmw_fastrtps_shared_cpp/src/rmw_response.cpp: __rmw_send_response).
    """
    dispatcher = Dispatcher()
    server = Recorder(node, dispatcher, FollowJointTrajectory, '/arm/follow')
    client = ActionClient(node, FollowJointTrajectory, '/arm/follow')
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    assert client.wait_for_server(30.0)
    answer = client.send_goal_async(FollowJointTrajectory.Goal())

    for _ in range(100):
        executor.spin_once(0.1)
        if node.asked:
            break
    assert node.asked
    assert not server.goals

    node.readers = True
    dispatcher.post_later(0.01, dispatcher.stop)
    dispatcher.run()
    for _ in range(100):
        executor.spin_once(0.1)
        if answer.done():
            break
    assert len(server.goals) == 1
    assert not answer.result().accepted
    client.destroy()
    server.destroy()
    executor.shutdown()
