# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Linux's joystick interface, and which gamepad is taken."""

from contextlib import closing
import os
import struct

import pytest

from armsim_ros.errors import ArmsimError, ResourceError
from armsim_ros.nodes.teleop.gamepad import Joystick


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
