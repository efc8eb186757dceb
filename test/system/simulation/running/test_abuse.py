# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Clients that die, and messages that make no sense."""

from __future__ import annotations

import math
import random
import sys
from typing import Any

from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
import pytest
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.trajectory import SUCCEEDED, trajectory_message, TrajectoryClient
from armsim_ros.testing.program import Program, ros_environment

ARM = '/sunday/arm_joint_controller'
JOINTS = [f'joint_{i}' for i in range(1, 7)]
DYING_CLIENT = f"""
import os
from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.trajectory import trajectory_message, TrajectoryClient
client = TrajectoryClient(ClientNode(int(os.environ['ROS_DOMAIN_ID'])), '{ARM}')
goal = client.send(trajectory_message({JOINTS}, [(1.0, [0.1] * 6)]))
goal.wait_for_feedback()
os.kill(os.getpid(), 9)
"""
NUMBERS = (math.nan, math.inf, -math.inf, 1e308, -1e308, 0.0, 1.0, -7.0)
TIMES = (-(2**31), -1, 0, 1, 2, 2**31 - 1)


@pytest.fixture(scope='module')
def arm(simulation: Program, client: ClientNode) -> TrajectoryClient:
    """Give a client of the arm's controller."""
    return TrajectoryClient(client, ARM)


def garbage(dice: random.Random) -> JointTrajectory:
    """Return a trajectory that no controller may follow."""

    def numbers(*counts: int) -> list[float]:
        return [dice.choice(NUMBERS) for _ in range(dice.choice(counts))]

    points = [
        JointTrajectoryPoint(
            positions=[*numbers(0, 3, 5), math.nan],
            velocities=numbers(0, 6, 7),
            accelerations=numbers(0, 6),
            effort=numbers(0, 0, 6),
            time_from_start=Duration(sec=dice.choice(TIMES), nanosec=dice.choice((0, 2**32 - 1))),
        )
        for _ in range(dice.randint(0, 3))
    ]
    trajectory = JointTrajectory(
        joint_names=dice.choice((JOINTS, JOINTS[:3], ['x'] * 6, [])), points=points
    )
    trajectory.header.stamp.sec = dice.choice(TIMES)
    return trajectory


def works(arm: TrajectoryClient) -> bool:
    """Return whether a good goal succeeds."""
    return arm.send(trajectory_message(JOINTS, [(0.5, [0.0] * 6)])).result().status == SUCCEEDED


def test_a_client_that_dies(
    simulation: Program, arm: TrajectoryClient, ros_domain: int
) -> None:
    """A client that is killed during its goal leaves a controller that works."""
    command = [sys.executable, '-c', DYING_CLIENT]
    program = Program(command, environment=ros_environment(ros_domain))
    with program:
        assert program.wait(60.0) == -9, program.text
    assert works(arm)


def test_messages_without_sense(
    simulation: Program, arm: TrajectoryClient, client: ClientNode
) -> None:
    """D14: 100 senseless goals and messages are refused, move nothing and leave no traceback."""
    assert works(arm)
    states = client.collect('/sunday/joint_states', JointState, 100)
    start = dict(zip(states.wait(1)[0].name, states.messages[0].position, strict=True))
    dice = random.Random(1)
    for _ in range(100):
        trajectory: Any = garbage(dice)
        goal = FollowJointTrajectory.Goal(
            trajectory=trajectory, goal_time_tolerance=Duration(sec=dice.choice(TIMES))
        )
        arm.publish(trajectory)
        assert not arm.send_goal(goal).accepted()
    for message in states.messages:
        now = dict(zip(message.name, message.position, strict=True))
        assert all(abs(now[name] - start[name]) < 1e-3 for name in JOINTS)
    states.close()
    assert works(arm)
    assert 'Traceback' not in simulation.text
