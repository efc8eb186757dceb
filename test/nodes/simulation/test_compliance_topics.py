# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Topics of compliant controllers: their names, what reaches the controller, what is published."""

from types import SimpleNamespace

from geometry_msgs.msg import PoseStamped, WrenchStamped
import numpy as np
import pytest
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from armsim_ros.config.controllers.compliance import (
    CartesianControllerParameters,
    CrispPoseBroadcasterParameters,
    CrispTwistBroadcasterParameters,
)
from armsim_ros.control.broadcaster import SensorSample
from armsim_ros.nodes.simulation.controllers.sensor_topics import (
    ComplianceTopics,
    NetForceTopics,
    TipTopic,
)


class Node:
    """Endpoints without a middleware."""

    def __init__(self):
        self.callbacks, self.published, self.publishers = {}, {}, 1

    def create_subscription(self, kind, topic, callback, profile):
        self.callbacks[topic] = callback

    def create_publisher(self, kind, topic, profile):
        messages = self.published.setdefault(topic, [])
        return SimpleNamespace(publish=messages.append, get_subscription_count=lambda: 1)

    def count_publishers(self, topic):
        return self.publishers


class Controller:
    """Keeps what it receives."""

    def __init__(self, parameters, **more):
        self.parameters, self.active, self.received = parameters, True, []
        vars(self).update(more)

    def __getattr__(self, name):
        return lambda *values: self.received.append((name, *values))


@pytest.fixture
def node():
    """Return endpoints that only remember."""
    return Node()


def test_targets_reach_the_controller(node):
    """Names are relative to the manager's namespace; stiffness is taken on request."""
    parameters = CartesianControllerParameters(variable_stiffness={'enabled': True})
    controller = Controller(parameters)
    ComplianceTopics(node, controller)
    assert set(node.callbacks) == {
        'target_pose', 'target_joint', 'target_wrench', 'target_stiffness'}
    pose = PoseStamped()
    pose.header.frame_id, pose.pose.position.x = 'base', 0.5
    node.callbacks['target_pose'](pose)
    node.callbacks['target_joint'](JointState(name=['a'], position=[0.1]))
    wrench = WrenchStamped()
    wrench.wrench.force.z = -5.0
    node.callbacks['target_wrench'](wrench)
    node.callbacks['target_stiffness'](Float64MultiArray(data=[1.0] * 6))
    names = [entry[0] for entry in controller.received]
    assert names == ['receive_pose', 'receive_joints', 'receive_wrench', 'receive_stiffness']
    assert controller.received[0][1:] == ('base', (0.5, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    assert controller.received[2][1] == (0.0, 0.0, -5.0, 0.0, 0.0, 0.0)


def test_two_publishers_of_a_target_are_ignored(node):
    """The controller warns; nothing is taken until there is one again."""
    controller = Controller(CartesianControllerParameters())
    ComplianceTopics(node, controller)
    node.callbacks['target_stiffness'](Float64MultiArray(data=[1.0] * 6))  # not enabled
    node.publishers = 2
    node.callbacks['target_wrench'](WrenchStamped())
    assert controller.received == [('ignore', 'target_wrench', 2)]
    controller.active = False
    node.callbacks['target_wrench'](WrenchStamped())
    assert len(controller.received) == 1


def test_the_tip_is_published(node):
    """The pose in the base frame, the twist in the tip's."""
    frames = {'end_effector_frame': 'tool', 'base_frame': 'base'}
    TipTopic(node, lambda: CrispPoseBroadcasterParameters(**frames)).publish(
        SensorSample(1_500_000_000, np.array([1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0])))
    TipTopic(node, lambda: CrispTwistBroadcasterParameters(**frames)).publish(
        SensorSample(0, np.arange(6.0)))
    (pose,), (twist,) = node.published['current_pose'], node.published['current_twist']
    assert (pose.header.frame_id, pose.header.stamp.sec, pose.pose.position.z) == ('base', 1, 3.0)
    assert (twist.header.frame_id, twist.twist.angular.z) == ('tool', 5.0)


def test_net_force_controllers_have_topics_of_their_own(node):
    """Below the controller's name; feedback is published where it is requested."""
    parameters = SimpleNamespace(
        robot_base_link='base', solver=SimpleNamespace(publish_state_feedback=True))
    controller = Controller(parameters, takes_poses=True, takes_wrenches=True,
                            feedback=lambda: (0, np.eye(4), np.arange(6.0)))
    topics = NetForceTopics(node, controller)
    assert set(node.callbacks) == {'~/target_frame', '~/target_wrench', '~/ft_sensor_wrench'}
    node.callbacks['~/target_frame'](PoseStamped())
    node.callbacks['~/ft_sensor_wrench'](WrenchStamped())
    assert [entry[0] for entry in controller.received] == ['receive_pose', 'receive_measured']
    topics.publish(0)
    (pose,), (twist,) = node.published['~/current_pose'], node.published['~/current_twist']
    assert pose.header.frame_id == twist.header.frame_id == 'base'
    assert (pose.pose.orientation.w, twist.twist.linear.y) == (1.0, 1.0)
