# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""An arm under test grasps and lets go, by fingers of every kind and by suction."""

from pathlib import Path

import numpy as np
import pytest

from armsim_ros.errors import ControllerError
from armsim_ros.testing import assert_holds
from armsim_ros.testing.in_process import InProcessArm
from armsim_ros.testing.stacks import built_cell

statement = pytest.mark.statement

HAND = Path(__file__).parents[2] / 'support' / 'robots' / 'hand'


def new_arm(robot, **overrides):
    """Return an arm stepped by the test."""
    return InProcessArm(built_cell(str(robot), None, overrides))


def put_cube(arm):
    """Stand a cube between the fingers of the hand."""
    arm.spawn('post', (0.03,) * 3, (0.0, 0.0, 1.12))
    arm.spawn('cube', (0.05,) * 3, (0.0, 0.0, 1.16), mass=0.3)


@statement('G3', 'G6')
@pytest.mark.parametrize('kind', ['fingers', 'parallel_fingers', 'effort_fingers'])
def test_fingers_grasp_and_release(kind):
    """By the gripper controller that is active; what is held is told."""
    arm = new_arm(HAND)
    if kind != 'fingers':
        assert arm.sim.manager.switch([kind], ['fingers']).ok
    arm.wait(0.1)
    put_cube(arm)
    arm.grasp(10.0)
    assert_holds(arm, 'cube')
    arm.delete('post')
    arm.move_to({'carriage_x': 0.2, 'carriage_z': 0.1})
    assert_holds(arm, 'cube')
    height = 1.16 + arm.positions['carriage_z']
    assert arm.entity('cube')[2, 3] == pytest.approx(height, abs=1e-3)
    arm.release()
    assert arm.held() == ()
    with pytest.raises(AssertionError, match="does not hold 'cube' but nothing"):
        assert_holds(arm, 'cube')


@statement('G3', 'G6')
def test_fingers_of_a_trajectory_controller_grasp():
    """Each finger with a motor and no gripper controller: the named states move them."""
    arm = new_arm('ROBOT', **{'simulation.world': 'empty'})
    tool = arm.sim.simulation.link_pose('tool')[:3, 3]
    arm.release()
    arm.spawn('post', (0.02,) * 3, tool - np.array([0.0, 0.0, 0.06]))
    arm.spawn('cube', (0.05,) * 3, tool, mass=0.1)
    arm.grasp()
    assert_holds(arm, 'cube')


@statement('G3', 'G6')
def test_a_suction_cup_grasps():
    """On and off; a cube before the cup is pulled and held."""
    arm = new_arm('sunday', **{
        'simulation.world': 'empty', 'simulation.initial_state': 'scan_food'})
    pose = arm.sim.simulation.link_pose('link_6')
    rim = pose[:3, 3] + 0.005 * pose[:3, 0]
    arm.spawn('post', (0.04, 0.04, 0.02), rim + 0.061 * pose[:3, 0])
    arm.spawn('cube', (0.04,) * 3, rim + 0.03 * pose[:3, 0], mass=0.1)
    arm.grasp()
    assert_holds(arm, 'cube')
    arm.release()
    assert arm.held() == ()


@statement('G3')
def test_an_arm_without_a_hand_says_so():
    """The sentence tells what the arm would need."""
    with pytest.raises(ControllerError, match='no suction cup, and no named state'):
        new_arm('elfin').grasp()
