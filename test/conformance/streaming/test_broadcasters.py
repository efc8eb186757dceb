# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Broadcasters of sensors and of the speed, seen through ROS alone."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
import math

from control_msgs.msg import Float64Values, Keys, SpeedScalingFactor
from controller_manager_msgs.srv import ListHardwareInterfaces, SwitchController
from geometry_msgs.msg import PoseStamped, WrenchStamped
import numpy as np
import pytest
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from sensor_msgs.msg import Imu
from std_msgs.msg import Float64
from std_srvs.srv import Trigger
from streaming_bench import ARM, beside, BROADCASTERS, MANAGER, NAMESPACE, PLACE, Streamed
from tf2_msgs.msg import TFMessage

statement = pytest.mark.statement


@pytest.fixture(scope='module')
def broadcasters(stack: Streamed) -> Iterator[None]:
    """Have all broadcasters active."""
    stack.client.call(f'{MANAGER}/switch_controller', SwitchController, SwitchController.Request(
        activate_controllers=BROADCASTERS, strictness=2))
    yield
    stack.client.call(f'{MANAGER}/switch_controller', SwitchController, SwitchController.Request(
        deactivate_controllers=BROADCASTERS, strictness=2))


@pytest.mark.usefixtures('broadcasters')
@statement('BRO-1')
def test_wrench(arm: Streamed) -> None:
    """
    The weight beyond the wrist comes in its axes; without a filter chain nothing is filtered.

    force_torque_sensor_broadcaster.cpp, update_and_write_commands.
    """
    name = f'{NAMESPACE}/wrench'
    with closing(arm.client.collect(f'{name}/wrench_filtered', WrenchStamped)) as filtered:
        with closing(arm.client.collect(f'{name}/wrench', WrenchStamped)) as messages:
            message = messages.wait(3)[-1]
        assert not filtered.messages
    assert message.header.frame_id == 'link_6'
    force = message.wrench.force
    assert 0.1 < math.hypot(force.x, force.y, force.z) < 50.0


@pytest.mark.usefixtures('broadcasters')
def test_tare(arm: Streamed) -> None:
    """The present load reads as 0; a second broadcaster of the sensor has a zero of its own."""
    answer = arm.client.call(f'{NAMESPACE}/load/tare', Trigger)
    assert answer.success, answer.message
    with closing(arm.client.collect(f'{NAMESPACE}/load/wrench', WrenchStamped)) as messages:
        messages.wait_for(lambda message: math.hypot(
            message.wrench.force.x, message.wrench.force.y, message.wrench.force.z) < 0.05)


@pytest.mark.usefixtures('broadcasters')
@statement('BRO-2')
def test_imu(arm: Streamed) -> None:
    """At rest the acceleration is what holds the link up."""
    with closing(arm.client.collect(f'{NAMESPACE}/imu/imu', Imu)) as messages:
        message = messages.wait(3)[-1]
    acceleration = message.linear_acceleration
    assert message.header.frame_id == 'link_3'
    assert math.hypot(acceleration.x, acceleration.y, acceleration.z) == pytest.approx(9.8, 0.01)


@pytest.mark.usefixtures('broadcasters')
def test_states(arm: Streamed) -> None:
    """
    The names come also to those that subscribe late, the values in their order.

    state_interfaces_broadcaster.cpp, on_configure and update.
    """
    latched = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
    with (
        closing(arm.client.collect(f'{NAMESPACE}/states/names', Keys, latched)) as names,
        closing(arm.client.collect(f'{NAMESPACE}/states/values', Float64Values)) as values,
    ):
        assert list(names.wait(1)[0].keys) == ['joint_3/position', 'accelerometer/orientation.w']
        position, turn = values.wait(3)[-1].values
    assert position == pytest.approx(PLACE[2], abs=5e-3)
    assert abs(turn) <= 1.0


@pytest.mark.usefixtures('broadcasters')
@statement('BRO-2')
def test_pose(arm: Streamed) -> None:
    """The pose comes on its topic and on /tf, under the sensor's name."""
    with (
        closing(arm.client.collect(f'{NAMESPACE}/tcp/pose', PoseStamped)) as poses,
        closing(arm.client.collect('/tf', TFMessage, QoSProfile(depth=100))) as transforms,
    ):
        place = poses.wait(3)[-1].pose.position
        found = transforms.wait_for(
            lambda message: any(one.child_frame_id == 'tool' for one in message.transforms))
    (transform,) = [one for one in found.transforms if one.child_frame_id == 'tool']
    assert transform.header.frame_id == 'base_link'
    there = transform.transform.translation
    np.testing.assert_allclose(
        (place.x, place.y, place.z), (there.x, there.y, there.z), atol=1e-3)


@pytest.mark.usefixtures('broadcasters')
@statement('UR-2')
def test_speed(arm: Streamed) -> None:
    """Full speed is 100 percent; its interface is listed."""
    with closing(arm.client.collect(f'{NAMESPACE}/speed/speed_scaling', Float64)) as messages:
        message = messages.wait(3)[-1]
    assert message.data == 100.0
    answer = arm.client.call(f'{MANAGER}/list_hardware_interfaces', ListHardwareInterfaces)
    states = {one.name for one in answer.state_interfaces}
    assert {'speed_scaling/speed_scaling_factor', 'wrist/force.x'} <= states


@statement('UR-1')
@pytest.mark.parametrize('factor', [math.nan, -1.0, math.inf])
def test_senseless_factors(arm: Streamed, factor: float) -> None:
    """They are dropped with a warning; the arm moves as before."""
    topic = f'{NAMESPACE}/{ARM}/speed_scaling_input'
    marker = len(arm.program.text)
    with arm.publisher(SpeedScalingFactor, topic) as publisher:
        arm.stream_until(
            publisher, SpeedScalingFactor(factor=factor),
            lambda: 'speed scaling factor' in arm.program.text[marker:], 'the reason is told')
        arm.go(beside(0.1))
        arm.go(PLACE)
