# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What clients rely on of the joints themselves."""

from __future__ import annotations

from controller_bench import Bench, TrajectoryController
import pytest
from sensor_msgs.msg import JointState

from armsim_ros.clients.trajectory import SUCCEEDED

statement = pytest.mark.statement


@statement('O2', 'O3', 'O4', 'U1')
@pytest.mark.parametrize('target', [[0.5, -0.5], [-1.0, 1.0]])
def test_it_settles_within_what_moveit_allows(
    arm: TrajectoryController, target: list[float]
) -> None:
    """After a motion every joint comes to rest within 0.01 rad of the last waypoint."""
    assert arm.run(arm.to(target, 0.3)).status == SUCCEEDED
    arm.next_state(lambda s: max(abs(v) for v in s.feedback.velocities) < 1e-3)
    assert arm.newest().feedback.positions == pytest.approx(target, abs=0.01)


@statement('O8', 'O9')
def test_joints_without_a_controller_hold(bench: Bench) -> None:
    """Joints that nobody commands stay where they are."""
    c = bench.use('arm')
    c.go([0.4, 0.2])
    bench.activate()
    topic = bench.client.collect(bench.name('joint_states'), JointState)
    messages = topic.wait(20)
    topic.close()
    for message in (messages[0], messages[-1]):
        position = dict(zip(message.name, message.position, strict=True))
        assert position['axis_1'] == pytest.approx(0.4, abs=0.01)
        assert position['drive_1'] == pytest.approx(
            dict(zip(messages[0].name, messages[0].position, strict=True))['drive_1'], abs=1e-3
        )
