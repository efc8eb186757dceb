# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Transforms of links."""

import math
from types import SimpleNamespace
from typing import Any

from geometry_msgs.msg import Transform
import numpy as np
import pytest
from rclpy.serialization import deserialize_message
from tf2_msgs.msg import TFMessage

from armsim_ros.model.robot_model import (
    Joint,
    JointType,
    Link,
    RobotModel,
    SemanticModel,
    VirtualJoint,
)
from armsim_ros.model.transforms import (
    matrix_from_axis_angle,
    matrix_from_quat_xyzw,
    matrix_from_rpy,
    pose_from_parts,
)
from armsim_ros.nodes.simulation.tf import Tf

AXIS = np.array([0.6, 0.0, 0.8])
ORIGIN = pose_from_parts([0.1, 0.2, 0.3], matrix_from_rpy([0.4, -0.5, 0.6]))


class Recorder:
    """Stands for a node: keeps what is published."""

    def __init__(self) -> None:
        self.published: dict[str, list[Any]] = {}

    def create_publisher(self, _kind: type, topic: str, _qos: object) -> Any:
        messages = self.published.setdefault(topic, [])

        def publish(message: TFMessage | bytes) -> None:
            is_serialized = isinstance(message, bytes)
            messages.append(deserialize_message(message, TFMessage) if is_serialized else message)

        return SimpleNamespace(publish=publish, get_subscription_count=lambda: 1)


@pytest.fixture
def robot() -> RobotModel:
    """Give a robot with one joint of each kind."""
    joints = [
        Joint('turn', JointType.REVOLUTE, 'base', 'arm', ORIGIN, AXIS),
        Joint('slide', JointType.PRISMATIC, 'arm', 'hand', ORIGIN, AXIS),
        Joint('mount', JointType.FIXED, 'hand', 'tool', ORIGIN, AXIS),
    ]
    return RobotModel(
        'robot',
        {name: Link(name) for name in ('base', 'arm', 'hand', 'tool')},
        {joint.name: joint for joint in joints},
        'base',
        SemanticModel(virtual_joint=VirtualJoint('v', 'fixed', 'world', 'base')),
    )


def matrix(transform: Transform) -> np.ndarray:
    """Return a transform message as (4, 4)."""
    t, r = transform.translation, transform.rotation
    return pose_from_parts([t.x, t.y, t.z], matrix_from_quat_xyzw([r.x, r.y, r.z, r.w]))


def by_child(message: TFMessage) -> dict[str, Any]:
    """Return child frame -> transform."""
    return {stamped.child_frame_id: stamped for stamped in message.transforms}


def test_movable_joints_turn_and_slide(robot: RobotModel) -> None:
    """The transform is the joint's origin times its motion."""
    node = Recorder()
    Tf(node, robot, np.eye(4)).publish(3_000_000_004, np.array([0.7, 0.25]))
    frames = by_child(node.published['/tf'][-1])
    assert set(frames) == {'arm', 'hand'}
    turned = ORIGIN @ pose_from_parts([0, 0, 0], matrix_from_axis_angle(AXIS, 0.7))
    np.testing.assert_allclose(matrix(frames['arm'].transform), turned, atol=1e-12)
    slid = ORIGIN @ pose_from_parts(0.25 * AXIS, np.eye(3))
    np.testing.assert_allclose(matrix(frames['hand'].transform), slid, atol=1e-12)
    assert frames['arm'].header.frame_id == 'base'
    assert (frames['hand'].header.stamp.sec, frames['hand'].header.stamp.nanosec) == (3, 4)


def test_a_robot_at_rest_is_shown_at_every_time(robot: RobotModel) -> None:
    """Only the stamp changes while nothing moves; a motion that follows is shown."""
    node = Recorder()
    tf = Tf(node, robot, np.eye(4))
    shown = []
    for second, angle in enumerate((0.7, 0.7, 0.8)):
        tf.publish(second * 1_000_000_000, np.array([angle, 0.0]))
        arm = by_child(node.published['/tf'][-1])['arm']
        shown.append((arm.header.stamp.sec, arm.transform.rotation.w))
    assert [second for second, _ in shown] == [0, 1, 2]
    assert shown[0][1] == shown[1][1] != shown[2][1]


def test_quaternions_have_length_one(robot: RobotModel) -> None:
    """A quaternion that is not normalized is refused by tf2."""
    node = Recorder()
    tf = Tf(node, robot, np.eye(4))
    for angle in np.linspace(-3 * math.pi, 3 * math.pi, 13):
        tf.publish(0, np.array([angle, 0.0]))
        rotation = by_child(node.published['/tf'][-1])['arm'].transform.rotation
        length = math.hypot(rotation.x, rotation.y, rotation.z, rotation.w)
        assert length == pytest.approx(1.0, abs=1e-12)


def test_fixed_joints_and_the_placement_are_static(robot: RobotModel) -> None:
    """What never moves is published once; the virtual joint's frame is where the robot stands."""
    node = Recorder()
    Tf(node, robot, ORIGIN)
    frames = by_child(node.published['/tf_static'][0])
    assert set(frames) == {'tool', 'base'}
    assert frames['base'].header.frame_id == 'world'
    np.testing.assert_allclose(matrix(frames['base'].transform), ORIGIN, atol=1e-12)
    np.testing.assert_allclose(matrix(frames['tool'].transform), ORIGIN, atol=1e-12)
