# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the flight recorder keeps."""

import pytest

from armsim_ros.recording.flight_recorder import FlightRecorder
from armsim_ros.stack import ArmSim
from armsim_ros.trajectory import JointTrajectory


def test_each_goal_is_kept_once_with_its_time():
    """As a controller begins to follow it; one that is followed for long is one goal."""
    sim = ArmSim('sunday')
    controller = sim.managers['sunday'].controllers['arm_joint_controller']
    recorder = FlightRecorder(sim.cell, sim.simulation, sim.managers)
    sent = []
    for position in (0.05, 0.1):
        names = controller.parameters.joints
        sent.append((sim.simulation.time_ns, controller.send_goal(
            JointTrajectory(names, [0.1], [[position] * len(names)])).goal))
        for _ in range(30):
            sim.step(10)
            recorder.sample(sim.simulation.time_ns)
    assert [(kept.controller, kept.goal) for kept in recorder.goals] == [
        ('/sunday/arm_joint_controller', goal) for _, goal in sent]
    for kept, (time_ns, _) in zip(recorder.goals, sent, strict=True):
        assert (kept.time_ns - time_ns) * 1e-9 == pytest.approx(0.02, abs=0.02)
