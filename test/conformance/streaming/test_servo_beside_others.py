# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""servo_node where more than one program wants something of the arm."""

from __future__ import annotations

from geometry_msgs.msg import TwistStamped
import numpy as np
import pytest
from streaming_bench import ARM, Streamed

pytestmark = pytest.mark.usefixtures('statuses')
statement = pytest.mark.statement

TWIST = 1
FASTEST = 1.5
"""No joint of the robot may be quicker [rad/s]."""


@pytest.mark.alone  # a command that comes late is followed in less time, as upstream
@pytest.mark.usefixtures('references')
@statement('SRV-13')
def test_two_clients_at_once(arm: Streamed) -> None:
    """Commands that contradict each other make no step; who goes on alone has the arm."""
    arm.choose(TWIST)
    arm.forget()
    other = arm.client.node.create_publisher(TwistStamped, '/servo_node/delta_twist_cmds', 10)
    arm.until(lambda: other.get_subscription_count() > 0, 'servo listens to the other client')
    down, up = arm.make_twist((0, 0, -0.5)), arm.make_twist((0, 0, 0.5))
    commanded = len(arm.moved(arm.reference))

    def enough() -> bool:
        return len(arm.moved(arm.reference)) > commanded + 100

    while not enough():
        arm.stream(arm.twist, down, 0.01, 0.005)
        arm.stream(other, up, 0.01, 0.005)
    before = arm.positions
    arm.stream_until(arm.twist, down, arm.has_moved(before, 0.1), 'the arm follows the first')
    arm.rest()
    assert arm.largest_speed() < FASTEST
    arm.client.in_executor(lambda: arm.client.node.destroy_publisher(other))


@pytest.mark.alone  # a command that comes late is followed in less time, as upstream
@pytest.mark.usefixtures('references')
@statement('SRV-21', 'FWD-9')
def test_another_controller_takes_over_while_jogging(arm: Streamed) -> None:
    """The arm stops, commands are refused in words, and after the way back the next ones work."""
    arm.choose(TWIST)
    arm.forget()
    message = arm.make_twist((0, 0, -0.3))
    for _ in range(3):
        before = arm.positions
        arm.stream_until(arm.twist, message, arm.has_moved(before, 0.03), 'the arm moves')
        arm.use('position_stream')
        arm.stream_until(arm.twist, message, arm.has_said(ARM, -1), 'the status names it')
        arm.rest(0.1)
        before = arm.positions
        arm.stream(arm.twist, message, 0.2)
        np.testing.assert_allclose(arm.positions, before, atol=1e-3)
        arm.use(ARM)
        arm.rest(0.1)
        np.testing.assert_allclose(arm.positions, before, atol=2e-3)
        arm.forget()
    arm.stream_until(arm.twist, message, arm.has_moved(before, 0.03), 'the arm moves again')
    arm.rest()
    assert arm.largest_speed() < FASTEST
