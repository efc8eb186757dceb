# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Linux's joystick interface, and which gamepad is taken."""

from contextlib import closing
import os
import struct
import time

import pytest
from sensor_msgs.msg import Joy

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.ros_client import RosClient
from armsim_ros.errors import ArmsimError, ResourceError
from armsim_ros.nodes.teleop import devices
from armsim_ros.nodes.teleop.devices import find_gamepad, Joystick


@pytest.fixture
def device(tmp_path):
    """Give a pipe in place of a device: its path, and the end that a driver writes to."""
    path = tmp_path / 'js0'
    os.mkfifo(path)
    reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)  # else it could not be written to yet
    writer = os.open(path, os.O_WRONLY)
    yield path, writer
    os.close(writer)
    os.close(reader)


def event(value, kind, number):
    """Return an event as the kernel writes it (linux/joystick.h, struct js_event)."""
    return struct.pack('=IhBB', 12345, value, kind, number)


def test_events_become_axes_and_buttons(device):
    """Those of the start (0x80) as well; up and left are positive, as in sensor_msgs/Joy."""
    path, writer = device
    with closing(Joystick(str(path))) as joystick:
        assert joystick.read() == ([], [])
        os.write(writer, event(0, 0x82, 1) + event(0, 0x81, 4) + event(-32767, 2, 1))
        assert joystick.read() == ([0, 1.0], [0] * 5)
        os.write(writer, event(1, 1, 4) + event(16384, 2, 0))
        axes, buttons = joystick.read()
        assert axes == pytest.approx([-0.5, 1.0], abs=1e-3)
        assert buttons == [0, 0, 0, 0, 1]
        assert joystick.read() == (axes, buttons)


def test_a_device_that_is_not_there_is_named(tmp_path):
    """With what to do."""
    with pytest.raises(ResourceError, match=r"js7' cannot be opened: No such file.*joy_node"):
        Joystick(str(tmp_path / 'js7'))


def test_a_device_that_is_gone_is_an_error(tmp_path):
    """As where its cable is pulled."""
    path = tmp_path / 'js0'
    path.write_bytes(b'')
    with closing(Joystick(str(path))) as joystick, pytest.raises(ArmsimError, match='is gone'):
        joystick.read()


@pytest.fixture
def clients():
    """Give the node of teleop, and that of a driver."""
    with RosClient('teleop') as client, ClientNode(name='driver') as driver:
        yield client, driver


def test_the_topic_is_taken_where_it_is_published(clients):
    """Its messages count until they cease."""
    client, driver = clients
    publisher = driver.node.create_publisher(Joy, '/joy', 10)
    timer = driver.node.create_timer(
        0.02, lambda: publisher.publish(Joy(axes=[0.5, -1.0], buttons=[1])))
    gamepad = find_gamepad(client, '', 20.0)
    assert [list(each) for each in gamepad.read()] == [[0.5, -1.0], [1]]
    driver.in_executor(timer.cancel)
    deadline = time.monotonic() + 20.0
    while gamepad.read() != ((), ()):
        assert time.monotonic() < deadline


def test_a_silent_topic_is_named(clients):
    """With what to check."""
    client, driver = clients
    driver.node.create_publisher(Joy, '/joy', 10)
    with pytest.raises(ArmsimError, match=r"no message on '/joy' within 0\.1 s.*autorepeat_rate"):
        find_gamepad(client, '', 0.1)


def test_without_topic_and_device_there_is_no_gamepad(clients, monkeypatch, tmp_path):
    """Both are named."""
    monkeypatch.setattr(devices, 'DEVICE', str(tmp_path / 'js0'))
    with pytest.raises(ResourceError, match=r"neither is '/joy' published nor is there .*js0'"):
        find_gamepad(clients[0], '', 1.0)
