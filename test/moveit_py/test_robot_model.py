# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joints, links and groups as scripts read them."""

import math

import pytest

from armsim_ros.config.robot_folder import find_files
from armsim_ros.errors import PlanningError
from armsim_ros.moveit_py.robot_model import RobotModel

pytestmark = pytest.mark.statement('C2')


def test_groups(model):
    """
    A group has all its joints, and among them those with a variable of their own.

    Groups are in the order of the alphabet (robot_model.cpp: buildGroups).
    """
    assert model.name == 'panda'
    assert model.joint_model_group_names == ['hand', 'panda_arm']
    hand, arm = model.joint_model_groups
    assert arm is model.get_joint_model_group('panda_arm')
    assert arm.joint_model_names[-1] == 'panda_joint8'
    assert arm.active_joint_model_names == [f'panda_joint{k}' for k in range(1, 8)]
    assert hand.active_joint_model_names == ['panda_finger_joint1']
    assert arm.link_model_names[-1] == 'panda_link8'


def test_an_unknown_group_lists_those_that_there_are(model):
    """Upstream returns None, and the script fails later."""
    assert not model.has_joint_model_group('arm')
    with pytest.raises(PlanningError, match='panda_arm, hand'):
        model.get_joint_model_group('arm')


def test_bounds(model):
    """Position and velocity come of the URDF; what it does not bound is not bounded."""
    arm = model.get_joint_model_group('panda_arm')
    (first,), *others = arm.active_joint_model_bounds
    assert len(others) == 6
    assert first.position_bounded
    assert first.min_position == pytest.approx(-first.max_position)
    assert first.min_velocity == -first.max_velocity
    assert not first.jerk_bounded
    assert first.max_jerk == 0.0
    upper = [bounds.max_position for bounds, in arm.active_joint_model_bounds]
    assert arm.satisfies_position_bounds(upper)
    assert not arm.satisfies_position_bounds([value + 0.1 for value in upper])
    assert arm.satisfies_position_bounds([value + 0.1 for value in upper], 0.2)
    with pytest.raises(ValueError, match='takes 7 values, 1 are given'):
        arm.satisfies_position_bounds([0.0])
    assert math.isfinite(first.max_velocity)


def test_the_end_effector_is_the_link_that_carries_it(model):
    """Only a group with exactly one has a name for it."""
    assert model.get_joint_model_group('panda_arm').eef_name == 'panda_link8'
    assert [each.name for each in model.end_effectors] == ['hand']
    with pytest.raises(RuntimeError, match='parent_link'):
        model.get_joint_model_group('hand').eef_name  # noqa: B018


def test_every_group_with_the_parent_link_has_the_end_effector():
    """Whichever is its parent_group (robot_model.cpp: buildGroupsInfoEndEffectors)."""
    files = find_files('ROBOT')
    model = RobotModel(urdf_xml_path=str(files.urdf_file), srdf_xml_path=str(files.srdf_file))
    for name in ('arm', 'arm_and_gripper'):
        assert model.get_joint_model_group(name).eef_name == 'l6'


def test_end_effectors_are_in_the_order_of_their_groups(tmp_path):
    """Not in that of the SRDF (robot_model.cpp: buildGroupsInfoEndEffectors)."""
    urdf, srdf = tmp_path / 'two.urdf', tmp_path / 'two.srdf'
    urdf.write_text('<robot name="two"><link name="a"/><link name="l"/><link name="r"/>'
                    '<joint name="jl" type="fixed"><parent link="a"/><child link="l"/></joint>'
                    '<joint name="jr" type="fixed"><parent link="a"/><child link="r"/></joint>'
                    '</robot>')
    srdf.write_text(
        '<robot name="two"><group name="right"><link name="r"/></group>'
        '<group name="left"><link name="l"/></group>'
        '<end_effector name="1" parent_link="a" group="right"/>'
        '<end_effector name="2" parent_link="a" group="left"/></robot>')
    model = RobotModel(urdf_xml_path=str(urdf), srdf_xml_path=str(srdf))
    assert [each.name for each in model.end_effectors] == ['left', 'right']


def test_model_info_names_all(model):
    """Joints, links and groups are in the text."""
    text = model.get_model_info()
    assert all(word in text for word in ('panda_joint1', 'panda_link8', 'group hand', 'mimics'))
