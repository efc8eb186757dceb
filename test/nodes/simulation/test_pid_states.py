# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The parts of the PID controller's commands, on ``~/<dof>/pid_state``."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace

from control_msgs.msg import PidState
import numpy as np
import pytest
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from armsim_ros.config.controllers.pid_controller import DofGains, PidControllerParameters
from armsim_ros.control.command_controllers.pid_controller import PidSnapshot
from armsim_ros.nodes.simulation.controllers.state_topics import PidStates, PidTopics

SNAPSHOT = PidSnapshot(
    1_500_000_000, ('a', 'b'), np.zeros((1, 2)), np.zeros((1, 2)),
    error=np.array([[0.1, 0.2], [0.3, 0.4]]), output=np.array([5.0, 6.0]),
    integral=np.array([0.7, 0.8]), period=0.25)


@pytest.fixture
def node(ros_domain_id: int) -> Iterator[Node]:
    """Give a node."""
    context = Context()
    context.init(domain_id=ros_domain_id)
    node = Node('loop', context=context, enable_rosout=False, start_parameter_services=False)
    yield node
    node.destroy_node()
    context.shutdown()


def test_the_parts_of_a_command_where_its_gains_ask_for_them(node: Node) -> None:
    """
    Error, change and integral part, with the gains as terms, and only of that joint.

    control_toolbox/src/pid_ros.cpp: PidROS::publish_pid_state.
    """
    parameters = PidControllerParameters(dof_names=('a', 'b'), gains={
        'a': DofGains(), 'b': DofGains(
            p=2.0, i=3.0, d=4.0, i_clamp_max=9.0, activate_state_publisher=True)})
    states = PidStates(node, SimpleNamespace(parameters=parameters))  # type: ignore[arg-type]
    received: list[PidState] = []
    node.create_subscription(PidState, '~/b/pid_state', received.append, 1)
    states.publish(SNAPSHOT)
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    while not received:
        executor.spin_once(timeout_sec=1.0)
    executor.shutdown()
    (message,) = received
    parts = (message.error, message.error_dot, message.p_error, message.i_error, message.d_error)
    assert parts == (0.2, 0.4, 0.2, 0.8, 0.4)
    assert (message.p_term, message.i_term, message.d_term) == (2.0, 3.0, 4.0)
    assert (message.i_min, message.i_max, message.output) == (-np.inf, 9.0, 6.0)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 500_000_000)
    assert message.timestep.nanosec == 250_000_000
    assert '/loop/a/pid_state' not in dict(node.get_topic_names_and_types())


def test_measured_states_are_taken_while_they_are_external(node: Node) -> None:
    """The topic follows the parameter (pid_controller.cpp, on_configure)."""
    controller = SimpleNamespace(parameters=PidControllerParameters())
    topics = PidTopics(node, controller)  # type: ignore[arg-type]
    assert node.count_subscribers('~/measured_state') == 0
    controller.parameters = PidControllerParameters(use_external_measured_states=True)
    topics.follow_parameters()
    assert node.count_subscribers('~/measured_state') == 1
    controller.parameters = PidControllerParameters()
    topics.follow_parameters()
    assert node.count_subscribers('~/measured_state') == 0
