# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which links are fingers: by the SRDF's end effectors, else by the controllers."""

from dataclasses import replace
from pathlib import Path

import pytest

from armsim_ros.model.cell_loading import load_cell
from armsim_ros.model.grippers import grippers_in
from armsim_ros.model.semantic_model import SemanticModel

HAND = Path(__file__).parent.parent / 'support' / 'robots' / 'hand'


def test_an_end_effector_is_a_gripper():
    """Its name, the link that carries it, its fingers; what is fixed to a link goes with it."""
    gripper, = grippers_in(load_cell('ROBOT'))
    assert (gripper.name, gripper.palm) == ('hand', 'l6')
    assert gripper.bodies == {
        'l6': 'l6', 'tool': 'l6', 'finger1': 'finger1', 'finger2': 'finger2'}


def test_without_one_a_gripper_controller_tells():
    """Its joint and those that mimic it move the fingers; controllers of one joint are one."""
    cell = load_cell(str(HAND))
    robot = replace(cell.robots[0], model=replace(
        cell.model, semantic=SemanticModel('hand', {}, {})))
    gripper, = grippers_in(replace(cell, robots=(robot,)))
    assert gripper.name == 'fingers'
    assert (gripper.palm, set(gripper.links)) == ('palm', {'palm', 'left_finger', 'right_finger'})


@pytest.mark.parametrize('robot', ['sunday', 'elfin'])
def test_an_arm_without_fingers_has_none(robot):
    """A suction cup is no gripper of this kind."""
    assert grippers_in(load_cell(robot)) == ()
