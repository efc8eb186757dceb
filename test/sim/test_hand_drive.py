# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A hand with a drive of its own: width, force and success, as libfranka's gripper.h has them."""

from pathlib import Path

import pytest

from armsim_ros.control.command_controllers.hand_drive import HandDrive, HandGoal
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.model.geometry import Box
from armsim_ros.model.grippers import grippers_in
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.sim.finger_contacts import FingerContacts
from armsim_ros.stack import ArmSim

HAND = Path(__file__).parents[1] / 'support' / 'robots' / 'hand'
CONTROLLER = 'fingers'


@pytest.fixture(scope='module')
def cell():
    """Return the files of the hand, read once."""
    return load_cell(str(HAND))


@pytest.fixture
def sim(cell):
    """Return a hand around a cube of 40 mm on a post, without its controller."""
    sim = ArmSim(cell)
    for name, size, z, mass in (('cube', 0.04, 1.155, 0.2), ('post', 0.03, 1.12, 0.0)):
        sim.simulation.world.add(WorldObject.of_shape(
            name, Box((size,) * 3), pose_matrix((0, 0, z)), mass=mass or None))
    assert sim.manager.switch([], [CONTROLLER]).ok
    return sim


@pytest.fixture
def drive(sim):
    """Return its drive."""
    drive = HandDrive.of('hand', 'finger_joint1', sim.manager.context)
    sim.manager.attach(drive)
    sim.step(20)
    return drive


def run(sim, drive, *goals):
    """Send goals; return the last when all have ended."""
    for goal in goals:
        drive.send(goal)
        sim.step(10)
    sim.run_until(lambda: all(goal.done for goal in goals), timeout=5.0)
    return goals[-1]


def grasp(width, force=20.0, epsilon=0.005):
    """Return a goal that closes the hand."""
    return HandGoal((width,), 0.1, force, (width - epsilon, width + epsilon))


def force_of(sim):
    """Return with what each finger presses what is between them [N]."""
    looks = FingerContacts(sim.simulation, grippers_in(sim.cell))
    return 0.5 * sum(contact.force for contact in looks.contacts(looks._grippers[0]))


def test_a_cube_is_grasped_at_its_width_with_the_force(sim, drive):
    """A cube of 40 mm and 20 N: within 1 mm and 2 N, until the hand is stopped."""
    assert run(sim, drive, grasp(0.04)).result.reached_goal
    sim.step(200)
    assert drive.width == pytest.approx(0.04, abs=0.001)
    assert force_of(sim) == pytest.approx(20.0, abs=2.0)
    drive.halt()
    sim.step(200)
    assert force_of(sim) < 2.0


def test_fingers_that_rest_at_another_width_have_not_grasped(sim, drive):
    """An object that is too wide, and none at all: no success, and the hand lets go of it."""
    assert not run(sim, drive, grasp(0.03)).result.reached_goal
    assert drive.width == pytest.approx(0.04, abs=0.001)
    sim.step(200)
    assert force_of(sim) < 2.0
    assert run(sim, drive, HandGoal((0.08,), 0.1)).result.reached_goal
    for name in ('cube', 'post'):
        sim.simulation.world.remove(name)
    goal = run(sim, drive, grasp(0.04))
    assert (goal.status.name, goal.error) == ('ABORTED', '')
    assert drive.width == pytest.approx(0.0, abs=0.001)


def test_a_motion_reaches_its_width_at_its_speed(sim, drive):
    """The width changes at the speed; a width beyond the hand's fails at once."""
    begin = sim.time
    assert run(sim, drive, HandGoal((0.05,), 0.03)).result.reached_goal
    assert sim.time - begin == pytest.approx(1.0, abs=0.05)
    assert drive.width == pytest.approx(0.05, abs=0.001)
    goal = drive.send(HandGoal((0.09,), 0.1))
    assert 'the width 0.09 m is not allowed' in goal.error


def test_a_motion_onto_an_object_fails(sim, drive):
    """The fingers do not reach a width that is narrower than what lies between them."""
    assert run(sim, drive, HandGoal((0.02,), 0.1)).status.name == 'ABORTED'
    assert drive.width == pytest.approx(0.04, abs=0.001)


def test_another_goal_stops_the_first(sim, drive):
    """The first ends as aborted; ``halt`` stops the second where it is."""
    first, second = HandGoal((0.05,), 0.02), HandGoal((0.0, 0.08), 0.02)
    drive.send(first)
    sim.step(50)
    drive.send(second)
    sim.step(50)
    assert (first.status.name, first.error) == ('ABORTED', 'another command replaced it')
    drive.halt()
    width = drive.width
    assert second.status.name == 'ABORTED'
    sim.step(500)
    assert drive.width == pytest.approx(width, abs=5e-4)


def test_a_stop_of_the_arm_leaves_the_grip(sim, drive):
    """The hand has a drive of its own; it goes on during a protective stop."""
    goal = drive.send(HandGoal((0.05,), 0.1))
    sim.step(20)
    sim.protective_stop()
    sim.run_until(lambda: goal.done, timeout=5.0)
    assert goal.result.reached_goal


def test_a_controller_of_the_fingers_has_them(sim, drive):
    """While a controller commands the fingers, goals fail with its name."""
    assert sim.manager.switch([CONTROLLER], []).ok
    goal = run(sim, drive, HandGoal((0.05,), 0.1))
    assert goal.error == f"controller '{CONTROLLER}' commands the fingers; deactivate it"
    sent = sim.manager.controllers[CONTROLLER].send_goal(0.03).goal
    sim.run_until(lambda: sent.done, timeout=5.0)
    sim.step(500)
    assert drive.width == pytest.approx(0.06, abs=0.001)


def test_no_client_sees_the_drive(sim, drive):
    """It is in no list, and at rest it costs no update."""
    assert [info.name for info in sim.manager.list_controllers()] == list(
        sim.manager.controllers)
    sim.step(500)
    assert sim.simulation.resting
    assert drive.next_update(sim.simulation.time_ns) > sim.simulation.time_ns


def test_a_reset_opens_nothing_and_leaves_the_drive_usable(sim, drive):
    """The goal ends, the fingers are held where the reset puts them, and goals go on."""
    goal = drive.send(HandGoal((0.05,), 0.01))
    sim.step(50)
    sim.loop.restart('reset')
    assert goal.status.name == 'ABORTED'
    sim.step(500)
    assert drive.width == pytest.approx(0.08, abs=0.001)
    assert run(sim, drive, HandGoal((0.06,), 0.1)).result.reached_goal
