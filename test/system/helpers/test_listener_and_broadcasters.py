# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Transforms from one node to another (upstream's test_listener_and_broadcaster.py)."""

from threading import Event

import pytest
import rclpy
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from stamped_transforms import at, stamped
from tf2_msgs.srv import FrameGraph
import tf2_ros

PATIENCE = Duration(seconds=20)


@pytest.fixture
def context(ros_domain_id):
    """Return a context of its own, shut down afterwards."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain_id)
    yield context
    context.try_shutdown()


@pytest.fixture
def sender(context):
    """Return a node that publishes."""
    return rclpy.create_node('sender', context=context)


@pytest.fixture
def receiver(context):
    """Return a node that listens."""
    return rclpy.create_node('receiver', context=context)


def test_transforms_arrive(sender, receiver):
    """A single transform, a tuple of several, and static transforms."""
    buffer = tf2_ros.Buffer(node=receiver)
    tf2_ros.TransformListener(buffer, receiver, spin_thread=True)
    broadcaster = tf2_ros.TransformBroadcaster(sender)
    while not broadcaster.pub_tf.get_subscription_count():
        sender.get_clock().sleep_for(Duration(seconds=0.02))
    sent = [stamped('base', 'tool', 1.0, (1, 2, 3)), stamped('tool', 'camera', 1.0)]
    broadcaster.sendTransform(sent[0])
    assert buffer.lookup_transform('base', 'tool', at(1.0), PATIENCE) == sent[0]
    broadcaster.sendTransform(tuple(sent))
    assert buffer.lookup_transform('tool', 'camera', at(1.0), PATIENCE) == sent[1]
    tf2_ros.StaticTransformBroadcaster(sender).sendTransform(stamped('world', 'base'))
    assert buffer.can_transform('world', 'camera', at(0), PATIENCE)


def test_late_listeners_get_all_static_transforms(sender, receiver):
    """The newest pose of each child, whenever it was sent."""
    broadcaster = tf2_ros.StaticTransformBroadcaster(sender)
    broadcaster.sendTransform([stamped('base', 'left'), stamped('base', 'right')])
    broadcaster.sendTransform(stamped('base', 'left', 0.0, (1, 0, 0)))
    buffer = tf2_ros.Buffer()
    tf2_ros.TransformListener(buffer, receiver, spin_thread=True)
    assert buffer.can_transform('left', 'right', at(0), PATIENCE)
    assert buffer.lookup_transform('base', 'left', at(0)).transform.translation.x == 1


def test_an_unregistered_listener_hears_nothing(receiver):
    """Its subscriptions are gone; the node stays usable."""
    listener = tf2_ros.TransformListener(tf2_ros.Buffer(), receiver)
    assert len(list(receiver.subscriptions)) == 2
    listener.unregister()
    assert list(receiver.subscriptions) == []


@pytest.mark.parametrize('moment', range(12))
def test_the_thread_of_a_listener_ends_with_the_context(context, receiver, moment):
    """A program that shuts ROS down at any moment ends, whether it keeps the listener or not."""
    listener = tf2_ros.TransformListener(tf2_ros.Buffer(), receiver, spin_thread=True)
    Event().wait(moment * 5e-5)
    context.shutdown()
    listener.dedicated_listener_thread.join(20)
    assert not listener.dedicated_listener_thread.is_alive()


def test_the_frames_of_a_buffer_can_be_asked_for(context, sender, receiver):
    """The service tf2_frames, which view_frames calls."""
    buffer = tf2_ros.Buffer(node=receiver)
    buffer.set_transform_static(stamped('base', 'camera'), 'test')
    client = sender.create_client(FrameGraph, 'tf2_frames')
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(sender)
    executor.add_node(receiver)
    client.wait_for_service(20)
    future = client.call_async(FrameGraph.Request())
    executor.spin_until_future_complete(future, 20)
    assert future.result().frame_yaml == buffer.all_frames_as_yaml()
    executor.shutdown()
