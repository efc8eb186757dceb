# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Wrenches over ROS.

external_wrench_plugin.cpp ``handleApplyWrench`` answers when the longest wrench has ended, and
applies nothing where a body is not known.
"""

from __future__ import annotations

from builtin_interfaces.msg import Duration
from geometry_msgs.msg import Vector3, Wrench, WrenchStamped
from mujoco_ros2_control_msgs.msg import ExternalWrench, ExternalWrenchArray
from mujoco_ros2_control_msgs.srv import ApplyExternalWrench
import numpy as np
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header
from visualization_msgs.msg import MarkerArray
from world_user import WorldUser

from armsim_ros.arrays import Matrix
from armsim_ros.clients.simulation import SimulationClient

SERVICE = '/external_wrench/apply_wrench'


def push(frame: str, y: float, seconds: float = 0.3, ramp: float = 0.0) -> ExternalWrench:
    """Return a push along y."""
    return ExternalWrench(
        wrench=_stamped(frame, y), duration=_duration(seconds), ramp_down_duration=_duration(ramp))


def _stamped(frame: str, y: float) -> WrenchStamped:
    return WrenchStamped(
        header=Header(frame_id=frame), wrench=Wrench(force=Vector3(y=y)))


def _duration(seconds: float) -> Duration:
    return Duration(sec=int(seconds), nanosec=round(seconds % 1.0 * 1e9))


def apply(world: WorldUser, *pushes: ExternalWrench) -> ApplyExternalWrench.Response:
    """Call the service."""
    request = ApplyExternalWrench.Request(
        wrenches=ExternalWrenchArray(external_wrenches=list(pushes)))
    response: ApplyExternalWrench.Response = world.client.call(
        SERVICE, ApplyExternalWrench, request)
    return response


def test_the_service_pushes_an_object_and_answers_at_the_end(world: WorldUser) -> None:
    """The object has moved when the answer comes, and arrows were published."""
    simulation = SimulationClient(world.client)
    simulation.spawn('ball', 'armsim://box?size=0.05,0.05,0.05&mass=0.2', _pose())
    clock = world.client.collect('/clock', Clock)
    markers = world.client.collect('/external_wrench/wrench_markers', MarkerArray)
    clock.wait()
    before, start = simulation.pose('ball')[1, 3], clock.messages[-1].clock
    response = apply(world, push('ball', 2.0), push('link_6', 1.0, 0.1))
    assert response.success, response.message
    end = clock.messages[-1].clock
    passed = end.sec - start.sec + 1e-9 * (end.nanosec - start.nanosec)
    assert 0.25 < passed < 2.0
    assert simulation.pose('ball')[1, 3] - before > 0.05
    markers.wait_for(lambda message: any(
        each.header.frame_id == 'ball' for each in message.markers))
    for topic in (clock, markers):
        topic.close()


def test_what_is_not_possible_is_refused_as_a_whole(world: WorldUser) -> None:
    """An unknown frame, a ramp longer than the duration, and a number that is not finite."""
    for pushes, text in (
        ((push('link_6', 1.0), push('link_99', 1.0)), "no entity 'link_99'"),
        ((push('link_6', 1.0, 0.1, 0.2),), 'allowed: 0 to the duration'),
        ((push('link_6', float('nan')),), 'must be finite'),
    ):
        response = apply(world, *pushes)
        assert not response.success
        assert text in response.message


def test_messages_of_the_topic_are_held(world: WorldUser) -> None:
    """A wrench acts for 0.2 s after its message."""
    simulation = SimulationClient(world.client)
    simulation.spawn('ball', 'armsim://box?size=0.05,0.05,0.05&mass=0.2', _pose())
    before = simulation.pose('ball')[1, 3]
    publisher = world.client.node.create_publisher(
        WrenchStamped, '/external_wrench/wrench', 10)
    while not publisher.get_subscription_count():
        world.client.settle()
    publisher.publish(_stamped('ball', 3.0))
    world.client.collect('/clock', Clock).wait(60)
    assert simulation.pose('ball')[1, 3] - before > 0.05
    world.client.node.destroy_publisher(publisher)


def _pose() -> Matrix:
    pose = np.eye(4)
    pose[:3, 3] = 2.0, 0.0, 0.025
    return pose
