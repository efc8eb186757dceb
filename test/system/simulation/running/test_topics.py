# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the simulation tells by itself: states, clock, transforms, descriptions."""

from contextlib import closing
import itertools
import time
from typing import Any
from xml.etree import ElementTree

from diagnostic_msgs.msg import DiagnosticArray
import pytest
from rclpy.qos import qos_profile_sensor_data, QoSDurabilityPolicy, QoSReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.controller_manager import ParameterClient
from armsim_ros.nodes.conversions.time import ns_from_time

pytestmark = pytest.mark.usefixtures('simulation')


def heard(
    client: ClientNode, topic: str, kind: type[Any], qos: Any = 10, *, count: int
) -> list[Any]:
    """Return so many messages of a topic; later ones are not received."""
    with closing(client.collect(topic, kind, qos)) as messages:
        return messages.wait(count)


def test_joint_states_come_at_50_hz_of_simulated_time(client: ClientNode) -> None:
    """A16: 50 Hz by the stamps, which increase strictly."""
    messages = heard(client, '/sunday/joint_states', JointState, 100, count=60)
    stamps = [ns_from_time(message.header.stamp) for message in messages]
    steps = [b - a for a, b in itertools.pairwise(stamps)]
    assert all(step > 0 for step in steps)
    assert set(steps[5:]) == {20_000_000}


def test_joint_states_are_complete(client: ClientNode) -> None:
    """M3: one entry a joint in every array."""
    message = heard(client, '/sunday/joint_states', JointState, count=1)[0]
    assert sorted(message.name) == [f'joint_{i}' for i in range(1, 7)]
    assert len(message.position) == len(message.velocity) == len(message.effort) == 6


def test_a_best_effort_subscriber_gets_joint_states(client: ClientNode) -> None:
    """A12: any subscriber's choice matches."""
    heard(client, '/sunday/joint_states', JointState, qos_profile_sensor_data, count=3)


def test_the_publisher_of_joint_states_is_reliable_and_keeps_the_last(client: ClientNode) -> None:
    """A11: system default is reliable and transient-local on the publisher's side."""
    heard(client, '/sunday/joint_states', JointState, count=1)
    (info,) = client.node.get_publishers_info_by_topic('/sunday/joint_states')
    assert info.qos_profile.reliability == QoSReliabilityPolicy.RELIABLE
    assert info.qos_profile.durability == QoSDurabilityPolicy.TRANSIENT_LOCAL


def test_the_clock_agrees_with_the_wall_clock(client: ClientNode) -> None:
    """Stamps of simulated time and of the wall clock pass as the same time."""
    messages = heard(client, '/clock', Clock, qos_profile_sensor_data, count=20)
    times = [ns_from_time(message.clock) for message in messages]
    assert abs(times[-1] - time.time_ns()) < 2_000_000_000
    assert times == sorted(set(times))


def test_transforms_of_all_moving_links(client: ClientNode) -> None:
    """/tf has each movable joint's link."""
    message = heard(client, '/tf', TFMessage, count=1)[0]
    frames = {stamped.child_frame_id for stamped in message.transforms}
    assert frames == {f'link_{i}' for i in range(1, 7)}


def test_fixed_transforms_come_late_too(client: ClientNode) -> None:
    """/tf_static is latched and joins base and world."""
    message = client.latched('/tf_static', TFMessage)
    frames = {stamped.child_frame_id: stamped.header.frame_id for stamped in message.transforms}
    assert frames['base_link'] == 'base_footprint'


def test_descriptions_come_late_too(client: ClientNode) -> None:
    """The URDF and the SRDF are latched, whole and well-formed."""
    urdf = client.latched('/robot_description', String).data
    srdf = client.latched('/robot_description_semantic', String).data
    assert ElementTree.fromstring(urdf).tag == 'robot'
    groups = ElementTree.fromstring(srdf).findall('group')
    assert 'manipulator' in [group.get('name') for group in groups]
    publisher = ParameterClient(client, '/robot_state_publisher')
    assert publisher.get('robot_description') == urdf


def test_diagnostics_name_controllers_hardware_and_loop(client: ClientNode) -> None:
    """The first three names are those of the reference."""
    message = heard(client, '/diagnostics', DiagnosticArray, count=1)[0]
    assert {status.name for status in message.status} == {
        'controller_manager: Controllers Activity',
        'controller_manager: Hardware Components Activity',
        'controller_manager: Controller Manager Activity',
        'controller_manager: Arm Safety',
    }
    assert message.status[0].level == b'\0'
