# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A suction cup on the default arm: what it takes, what it holds, what it loses."""

import math

import numpy as np
import pytest

from armsim_ros.model.geometry import Box, Sphere
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.sim.vacuum_control import VacuumControl
from armsim_ros.stack import ArmSim
from armsim_ros.testing.stacks import built_cell

NAME = 'vacuum_gripper'


class Cup:
    """An arm that stands still with its cup."""

    def __init__(self):
        self.arm = ArmSim(built_cell('sunday', 'empty', {
            'simulation.initial_state': 'scan_food'}))
        self.changes = []
        self.gripper = self.arm.simulation.vacuum_grippers[NAME]
        self.control = VacuumControl(
            self.arm.loop, self.gripper, lambda: self.changes.append(self.gripper.held))
        pose = self.arm.simulation.link_pose('link_6')
        self.rim = pose[:3, :3] @ np.array([0.005, 0, 0]) + pose[:3, 3]
        self.down = pose[:3, 0]

    def put(self, name, distance, mass=0.1, aside=0.0, size=0.04):
        """Put a cube before the cup, so far from it [m]; it rests on a fixed one."""
        middle = self.rim + (distance + 0.5 * size) * self.down + aside * np.array([1, 0, 0])
        world = self.arm.simulation.world
        world.add(WorldObject.of_shape(
            name, Box((size, size, size)), pose_matrix(middle), mass=mass))
        world.add(WorldObject.of_shape(f'{name}_post', Box((size, size, 0.02)), pose_matrix(
            middle - [0, 0, 0.5 * size + 0.01])))

    def relative(self, name):
        """Return where an object is, seen from the cup's link (4, 4)."""
        simulation = self.arm.simulation
        return np.linalg.inv(simulation.link_pose('link_6')) @ simulation.world.pose(name)


@pytest.fixture
def cup():
    """Return an arm whose cup looks down."""
    return Cup()


def test_it_pulls_what_is_near_and_holds_it(cup):
    """A force brings it to the cup, no step is a jump, and it stays where it touched."""
    cup.put('cube', 0.02)
    cup.control.on()
    way = []
    for _ in range(400):
        cup.arm.step()
        way.append(cup.arm.simulation.world.pose('cube')[:3, 3])
    assert cup.changes == ['cube']
    assert np.linalg.norm(np.diff(way, axis=0), axis=1).max() < 2e-3
    before = cup.relative('cube')
    cup.arm.step(10_000)
    assert np.linalg.norm(cup.relative('cube')[:3, 3] - before[:3, 3]) < 1e-3
    cup.control.off()
    cup.arm.step(100)
    assert cup.changes == ['cube', '']
    assert cup.relative('cube')[0, 3] - before[0, 3] > 5e-3


@pytest.mark.parametrize(('distance', 'aside'), [(0.035, 0.0), (0.004, 0.08)])
def test_what_is_out_of_reach_stays(cup, distance, aside):
    """Farther than the reach, or beside the cup's axis."""
    cup.put('cube', distance, aside=aside)
    cup.control.on()
    cup.arm.step(300)
    assert cup.gripper.held == ''


def test_it_takes_the_nearest(cup):
    """Of several in reach the one whose surface is nearest; fixed ones never."""
    cup.put('cube', 0.02)
    world = cup.arm.simulation.world
    world.add(WorldObject.of_shape('ball', Sphere(0.005), pose_matrix(
        cup.rim + 0.008 * cup.down), mass=0.01))
    cup.control.on()
    cup.arm.step(100)
    assert cup.gripper.held == 'ball'


def test_it_loses_what_is_too_heavy(cup):
    """More than the holding force for 20 ms; the line names force and limit."""
    cup.put('cube', 0.0, mass=1.0)
    cup.control.on()
    cup.arm.step(50)
    assert cup.gripper.held == 'cube'
    cup.arm.simulation.world.remove('cube_post')
    cup.arm.step(500)
    assert cup.gripper.held == 'cube'
    body = cup.arm.simulation.mujoco_model.body('object/cube').id
    cup.arm.simulation.mujoco_data.xfrc_applied[body, 2] = -8.0
    cup.arm.step(200)
    assert cup.gripper.held == 'cube'  # 17.8 N
    cup.arm.simulation.mujoco_data.xfrc_applied[body, 2] = -13.0
    cup.arm.step(200)
    assert (cup.gripper.held, cup.gripper.on) == ('', False)
    line = cup.gripper.losses[0]
    assert "lost 'cube'" in line
    assert 'holds 20 N' in line


def test_it_loses_what_levers_it_off(cup):
    """A moment above the limit, though the force is below it."""
    cup.put('cube', 0.0, mass=0.1)
    cup.control.on()
    cup.arm.step(50)
    body = cup.arm.simulation.mujoco_model.body('object/cube').id
    for moment, held in ((0.8, 'cube'), (1.3, '')):
        cup.arm.simulation.mujoco_data.xfrc_applied[body, 3] = moment
        cup.arm.step(200)
        assert cup.gripper.held == held


def test_a_held_object_can_be_deleted_and_others_come(cup):
    """The world changes under the cup; what is held stays held, what has gone is let go."""
    cup.put('cube', 0.0)
    cup.control.on()
    cup.arm.step(50)
    cup.put('other', 0.5)
    cup.arm.step(50)
    assert cup.gripper.held == 'cube'
    before = cup.relative('cube')
    cup.arm.step(1000)
    after = cup.relative('cube')
    assert np.linalg.norm(after[:3, 3] - before[:3, 3]) < 1e-3
    np.testing.assert_allclose(after[:3, :3], before[:3, :3], atol=1e-2)
    cup.arm.simulation.world.remove('cube')
    cup.arm.step(10)
    assert cup.changes == ['cube', '']


def test_a_reset_switches_it_off(cup):
    """The object is back at its start, and nothing pulls."""
    cup.put('cube', 0.01)
    cup.control.on()
    cup.arm.step(400)
    assert cup.gripper.held == 'cube'
    cup.arm.loop.restart('reset')
    cup.arm.step(400)
    assert (cup.gripper.held, cup.gripper.on) == ('', False)
    assert cup.changes == ['cube', '']
    assert math.isclose(cup.relative('cube')[0, 3], 0.005 + 0.01 + 0.02, abs_tol=2e-3)


def test_it_carries_through_a_motion(cup):
    """Under half a gravity of acceleration the object stays within a millimetre."""
    cup.put('cube', 0.0, mass=0.3)
    cup.control.on()
    cup.arm.step(50)
    before = cup.relative('cube')
    cup.arm.simulation.world.remove('cube_post')
    cup.arm.execute(cup.arm.plan('home'))
    assert cup.gripper.held == 'cube'
    assert np.linalg.norm(cup.relative('cube')[:3, 3] - before[:3, 3]) < 1e-3
