# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Streams that end or stand still without a word from who sends them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import signal
import sys

import numpy as np
import pytest
from simulation_interfaces.msg import SimulationState
from simulation_interfaces.srv import SetSimulationState
from streaming_bench import Streamed

from armsim_ros.testing.program import Program, ros_environment

pytestmark = pytest.mark.usefixtures('statuses')
statement = pytest.mark.statement

JOG, TWIST = 0, 1
FASTEST = 1.5
"""No joint of the robot may be quicker [rad/s]."""
JOYSTICK = """
import time
from control_msgs.msg import JointJog
import rclpy
rclpy.init()
publisher = rclpy.create_node('joystick').create_publisher(
    JointJog, '/servo_node/delta_joint_cmds', 10)
while True:
    publisher.publish(JointJog(joint_names=['joint_6'], velocities=[0.4]))
    time.sleep(0.01)
"""
SPEED = 0.2
"""Of the joint that the joystick turns [rad/s]."""


@contextmanager
def paused(arm: Streamed) -> Iterator[None]:
    """Have simulated time stand still."""
    def set_to(state: int) -> None:
        request = SetSimulationState.Request(state=SimulationState(state=state))
        answer = arm.client.call('/set_simulation_state', SetSimulationState, request)
        assert answer.result.result == 1, answer.result.error_message

    set_to(SimulationState.STATE_PAUSED)
    try:
        yield
    finally:
        set_to(SimulationState.STATE_PLAYING)


@pytest.mark.alone  # a command that comes late is followed in less time, as upstream
@pytest.mark.usefixtures('references')
@statement('SRV-12')
def test_a_joystick_that_dies(arm: Streamed) -> None:
    """An arm whose joystick is killed on the way comes to rest, and the status says why."""
    arm.choose(JOG)
    before = arm.positions
    joystick = Program(
        [sys.executable, '-c', JOYSTICK], environment=ros_environment(arm.domain))
    with joystick:
        arm.until(arm.has_moved(before, 0.05), 'the joystick moves the arm')
        arm.forget()
        joystick.signal(signal.SIGKILL)
        at_death = arm.positions
        arm.until(arm.has_said('no command has come for 0.1 s', 0), 'the status says why')
    arm.rest()
    assert np.abs(arm.positions - at_death).max() < SPEED * 1.0
    assert arm.largest_speed() < FASTEST


@pytest.mark.alone  # a command that comes late is followed in less time, as upstream
@pytest.mark.usefixtures('references')
@statement('SRV-12', 'SRV-21')
def test_time_that_stands_still(arm: Streamed) -> None:
    """After a pause of the simulation a jog goes on from where the arm is, with no step."""
    arm.choose(TWIST)
    down, before = arm.make_twist((0, 0, -0.3)), arm.positions
    arm.stream_until(arm.twist, down, arm.has_moved(before, 0.03), 'the arm moves')
    arm.forget()
    with paused(arm):
        arm.stream(arm.twist, down, 0.4)
        still = arm.positions
        arm.stream(arm.twist, down, 0.2)
        np.testing.assert_allclose(arm.positions, still, atol=1e-9)
    arm.stream_until(arm.twist, down, arm.has_moved(still, 0.03), 'the arm moves on')
    arm.rest()
    assert arm.largest_speed() < FASTEST
