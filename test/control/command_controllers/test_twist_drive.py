# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Twists of the tool in its own frame, as ros2_kortex sends them (sendTwistCommand)."""

import numpy as np
import pytest

from armsim_ros.control.command_controllers.twist_drive import TwistDrive
from armsim_ros.stack import ArmSim

ARM, TOOL = 'panda_arm_controller', 'panda_hand_tcp'
JOINTS = tuple(f'panda_joint{number}' for number in range(1, 8))


@pytest.fixture
def sim():
    """Return an arm without a controller of its joints."""
    sim = ArmSim('panda')
    assert sim.manager.switch([], [ARM]).ok
    return sim


@pytest.fixture
def drive(sim):
    """Return its drive by twists."""
    drive = TwistDrive.of('twist', JOINTS, TOOL, sim.manager.context)
    sim.manager.attach(drive)
    sim.step(20)
    return drive


def stream(sim, drive, twist, seconds):
    """Send a twist every 20 ms."""
    end = sim.time + seconds
    while sim.time < end:
        drive.receive(np.array(twist, dtype=float))
        sim.run_until(sim.time + 0.02)


def moved(sim, before):
    """Return how the tool has moved in its own frame of before, (4, 4)."""
    return np.linalg.inv(before) @ sim.simulation.link_pose(TOOL)


@pytest.mark.parametrize('axis', [0, 2, 3, 5])
def test_the_tool_moves_along_and_about_its_own_axes(sim, drive, axis):
    """A second of 0.1 m/s or rad/s moves the tool by 0.1 m or rad, but for speeding up."""
    before = sim.simulation.link_pose(TOOL)
    twist = np.zeros(6)
    twist[axis] = 0.1
    stream(sim, drive, twist, 1.0)
    sim.run_until(sim.time + 0.5)
    motion = moved(sim, before)
    turn = motion[:3, :3]
    angles = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0],
                             turn[1, 0] - turn[0, 1]])
    found = np.concatenate((motion[:3, 3], angles))
    assert found[axis] == pytest.approx(0.11, abs=0.012)
    assert np.abs(np.delete(found, axis)).max() < 0.004


def test_the_arm_stops_a_tenth_of_a_second_after_the_last_twist(sim, drive):
    """Nothing has to send a zero; at rest the drive costs no update."""
    stream(sim, drive, (0.1, 0, 0, 0, 0, 0), 0.5)
    assert np.abs(sim.simulation.state.velocity[:7]).max() > 0.01
    sim.run_until(sim.time + 0.2)
    assert np.abs(sim.simulation.state.velocity[:7]).max() < 1e-3
    assert drive.next_update(sim.simulation.time_ns) > sim.simulation.time_ns


def test_nothing_of_a_twist_is_left_after_a_stop(sim, drive):
    """The stop ends it; twists meanwhile are not kept."""
    stream(sim, drive, (0.1, 0, 0, 0, 0, 0), 0.5)
    sim.protective_stop()
    sim.step(20)
    drive.receive(np.array([0.1, 0, 0, 0, 0, 0]))
    sim.run_until(sim.time + 0.5)
    sim.clear_stop()
    before = sim.simulation.link_pose(TOOL)
    sim.run_until(sim.time + 0.5)
    assert np.abs(moved(sim, before) - np.eye(4)).max() < 1e-4


def test_a_controller_of_the_arm_has_it(sim, drive):
    """Twists are ignored, with one warning that names the controller."""
    assert sim.manager.switch([ARM], []).ok
    before = sim.simulation.link_pose(TOOL)
    stream(sim, drive, (0.1, 0, 0, 0, 0, 0), 0.5)
    assert np.abs(moved(sim, before) - np.eye(4)).max() < 1e-4
    lines = [event.text for event in sim.manager.poll_events() if event.source == 'twist']
    assert lines == [f"twists are ignored while '{ARM}' commands the arm; deactivate it"]
