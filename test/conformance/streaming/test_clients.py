# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Clients of others, as they are installed or with the calls that they make."""

from __future__ import annotations

import time

import numpy as np
import pytest
from std_srvs.srv import SetBool
from streaming_bench import beside, Streamed

statement = pytest.mark.statement


@statement('SRV-23')
@pytest.mark.parametrize('legacy', [False, True])
def test_pymoveit2(arm: Streamed, legacy: bool) -> None:
    """MoveIt2Servo moves the arm with Jazzy's services and with Humble's."""
    servo_module = pytest.importorskip('pymoveit2.moveit2_servo')
    servo = servo_module.MoveIt2Servo(
        arm.client.node, 'base_link', linear_speed=0.2, angular_speed=0.2,
        legacy_interface=legacy,
    )
    try:
        before = arm.positions
        end = time.monotonic() + 10.0
        while time.monotonic() < end and np.abs(arm.positions - before).max() < 0.05:
            servo(linear=(0.0, 0.0, -1.0), angular=(0.0, 0.0, 0.0))
            time.sleep(0.02)
        assert np.abs(arm.positions - before).max() > 0.04
        servo.disable()
        arm.rest()
    finally:
        arm.client.in_executor(servo.destroy)


@statement('SRV-23')
def test_robot_class_with_servo(arm: Streamed) -> None:
    """A robot class that unpauses, chooses TWIST and sends twists in base_link moves the arm."""
    arm.client.call('/servo_node/pause_servo', SetBool, SetBool.Request(data=False))
    assert arm.choose(1)
    before = arm.positions
    arm.stream_until(
        arm.twist, arm.make_twist((0, 0, -0.2)), arm.has_moved(before, 0.03), 'the arm moves')
    arm.rest()


@statement('SRV-23')
def test_robot_class_with_trajectories(arm: Streamed) -> None:
    """Trajectories of one point at time 0, thirty a second, lead the arm."""
    from streaming_bench import JOINTS
    from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

    for step in range(30):
        target = beside(0.01 * (step + 1))
        message = JointTrajectory(
            joint_names=list(JOINTS),
            points=[JointTrajectoryPoint(positions=[float(value) for value in target])],
        )
        arm.trajectory.publish(message)
        time.sleep(1.0 / 30.0)
    arm.until(lambda: abs(arm.positions[0] - 0.3) < 5e-3, 'the last point is reached')
