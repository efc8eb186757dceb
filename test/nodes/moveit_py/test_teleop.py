# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A joystick's messages become twists, and a policy's node has its topics."""

from dataclasses import astuple
from types import SimpleNamespace

import pytest
import rclpy
from sensor_msgs.msg import Joy
from std_srvs.srv import SetBool

from armsim_ros.moveit_py import devices
from moveit.policies import Policy
from moveit.servo_client.devices.ps4_dualshock import PS4DualShockTeleop

pytestmark = pytest.mark.statement('C8')


@pytest.fixture
def ros():
    """Initialize the default context."""
    rclpy.init()
    yield
    rclpy.shutdown()


def test_a_twist_of_sticks_and_buttons(ros, monkeypatch):
    """In the frame of the end effector; a message with too few axes is left out."""
    device = PS4DualShockTeleop(ee_frame_name='panda_link8')
    sent = []
    monkeypatch.setattr(device.twist_publisher, 'publish', sent.append)
    device.publish_command(Joy(axes=[0.0], buttons=[]))
    assert not sent
    buttons = [0] * 13
    buttons[device.device_config.Buttons.R1] = 1
    device.publish_command(Joy(
        axes=[0.1, 0.2, 1.0, 0.4, 0.5, -1.0, 0.0, 0.0], buttons=buttons))
    message, = sent
    assert message.header.frame_id == 'panda_link8'
    linear, angular = message.twist.linear, message.twist.angular
    assert (linear.x, linear.y, linear.z) == pytest.approx((1.0, 0.4, 0.5))
    assert (angular.x, angular.y, angular.z) == pytest.approx((0.1, 0.2, 1.0))
    monkeypatch.setattr(devices, '_SERVICE_TIMEOUT', 0.05)
    device.start_teleop()
    assert device.teleop_thread is None
    device.stop_teleop()
    device.destroy_node()


class Own(Policy):
    """A policy without sensors."""

    def forward(self, *messages):
        """Do nothing."""


def test_a_policy_is_activated_by_its_service(ros):
    """And by its attribute; unknown types are refused with those that are known."""
    command = SimpleNamespace(type='geometry_msgs/Twist', topic='twist', qos=1)
    values = SimpleNamespace(num_sensors=0, sensor_queue=1, sensor_slop=0.1, command=command)
    params = SimpleNamespace(
        ParamListener=lambda node: SimpleNamespace(get_params=lambda: values))
    policy = Own(params)
    assert not policy.is_active
    assert policy.activate_policy(SetBool.Request(data=True), SetBool.Response()).success
    assert policy.is_active
    policy.active = False
    assert not policy.is_active
    with pytest.raises(ValueError, match='sensor_msgs/Image'):
        policy.get_sensor_msg_type('sensor_msgs/PointCloud2')
    policy.destroy_node()


def test_places_of_axes_and_buttons_are_those_of_the_driver():
    """As in moveit_py/moveit/servo_client/devices/ps4_dualshock.py."""
    assert astuple(devices.DualShockAxes()) == tuple(range(8))
    buttons = astuple(devices.DualShockButtons())
    assert buttons == tuple(range(len(buttons)))
