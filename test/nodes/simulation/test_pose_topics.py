# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Poses and the transforms as which they are published."""

from __future__ import annotations

from collections.abc import Iterator
import math

from geometry_msgs.msg import PoseStamped
import numpy as np
import pytest
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from armsim_ros.config.controllers.broadcasters import PoseBroadcasterParameters, PoseTransform
from armsim_ros.control.broadcaster import SensorSample
from armsim_ros.nodes import qos
from armsim_ros.nodes.simulation.controllers.sensor_topics import is_pose, PoseTopics


@pytest.fixture
def node(ros_domain_id: int) -> Iterator[Node]:
    """Give a node."""
    context = Context()
    context.init(domain_id=ros_domain_id)
    node = Node('tcp', context=context, enable_rosout=False, start_parameter_services=False)
    yield node
    node.destroy_node()
    context.shutdown()


@pytest.mark.parametrize(
    ('values', 'sent'),
    [
        ([1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0], True),
        ([1.0, 2.0, 3.0, 0.0, 0.0, 0.004, 1.0], True),
        ([1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0], True),
        ([math.nan, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0], False),
        ([1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0], False),
        ([1.0, 2.0, 3.0, 0.0, 0.0, 0.5, 1.0], False),
    ],
)
def test_an_invalid_pose_is_no_transform(values: list[float], sent: bool) -> None:
    """The pose is published, the transform is not (pose_broadcaster.cpp, is_pose_valid)."""
    assert is_pose(values) is sent


def test_frames_and_transform_follow_the_parameters(node: Node) -> None:
    """Those with which it is configured again count (pose_broadcaster.cpp, on_configure)."""
    pose = np.array([1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0])
    parameters = PoseBroadcasterParameters(
        pose_name='tool', frame_id='world', tf=PoseTransform(enable=False))
    topics = PoseTopics(node, lambda: parameters)
    topics.publish(SensorSample(0, pose))
    assert node.count_publishers('/tf') == 0
    parameters = PoseBroadcasterParameters(pose_name='tool', frame_id='table')
    topics.publish(SensorSample(1_000_000_000, pose))
    assert node.count_publishers('/tf') == 1
    received: list[PoseStamped] = []
    node.create_subscription(PoseStamped, '~/pose', received.append, qos.LATCHED)
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    while not received:
        executor.spin_once(timeout_sec=1.0)
    executor.shutdown()
    assert received[-1].header.frame_id == 'table'
