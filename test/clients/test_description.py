# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A robot as its published texts tell it."""

import numpy as np
import pytest

from armsim_ros.clients.description import (
    bounds,
    describe,
    link_pose,
    moved_links,
    position_of,
    tip_of,
    with_limits,
)
from armsim_ros.model.transforms import quat_xyzw_from_matrix
from armsim_ros.model.tree import joint_pose

URDF = """<robot name="two">
  <link name="base"/>
  <link name="upper"><visual><geometry><mesh filename="package://p/m.dae" scale="2 2 2"/>
  </geometry></visual></link>
  <link name="lower"/><link name="slide"/>
  <joint name="turn" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 1" rpy="0.1 0.2 0.3"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="2" effort="1" velocity="3"/></joint>
  <joint name="spin" type="continuous"><parent link="upper"/><child link="lower"/>
    <origin xyz="0 0 1"/><axis xyz="0 0 1"/></joint>
  <joint name="push" type="prismatic"><parent link="lower"/><child link="slide"/>
    <origin xyz="0 0 1" rpy="0 0.5 0"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.5" effort="1" velocity="1"/></joint>
</robot>"""
SRDF = """<robot name="two"><group name="arm"><chain base_link="base" tip_link="slide"/></group>
<group name="end"><joint name="push"/></group></robot>"""


@pytest.fixture(scope='module')
def robot():
    """Describe the robot; its mesh is nowhere to be found."""
    return describe(URDF, SRDF)


def test_meshes_are_named_not_read(robot):
    """Address and scale are kept for who draws them."""
    mesh = robot.links['upper'].visuals[0].geometry
    assert (mesh.uri, mesh.vertices.tolist()) == ('package://p/m.dae', [[2.0, 2.0, 2.0]])


def test_the_texts_are_kept(robot):
    """The description is that of the topics, and declares no hardware of its own."""
    assert (robot.urdf, robot.srdf, robot.hardware) == (URDF, SRDF, ())


def test_links_stand_where_the_joints_put_them(robot):
    """The chain of the joints' poses."""
    positions = {'turn': 0.4, 'spin': -2.0, 'push': 0.2}
    expected = np.eye(4)
    for name in ('turn', 'spin', 'push'):
        expected = expected @ joint_pose(robot.joints[name], positions[name])
    assert link_pose(robot, 'slide', positions) == pytest.approx(expected)


@pytest.mark.parametrize(('joint', 'value'), [
    ('turn', -0.7), ('turn', 1.9), ('spin', 3.0), ('push', 0.3)])
def test_a_joint_position_is_read_off_its_transform(robot, joint, value):
    """What tf tells is enough."""
    pose = joint_pose(robot.joints[joint], value)
    read = position_of(robot.joints[joint], pose[:3, 3], quat_xyzw_from_matrix(pose))
    assert read == pytest.approx(value)


def test_a_joint_without_limits_turns_once_each_way(robot):
    """A slider needs ends."""
    assert bounds(robot.joints['spin']) == pytest.approx((-np.pi, np.pi))
    assert bounds(robot.joints['turn']) == (-1.0, 2.0)


def test_limits_of_a_planner_replace_those_of_the_urdf(robot):
    """The joints that are not named keep theirs."""
    limited = with_limits(robot, {'turn': {'velocity': 1.5, 'acceleration': 4.0}})
    assert limited.joints['turn'].limits.velocity == 1.5
    assert limited.joints['turn'].limits.acceleration == 4.0
    assert limited.joints['push'].limits == robot.joints['push'].limits


def test_a_group_has_a_tip_and_links_that_it_moves(robot):
    """Those below its first joint."""
    assert tip_of(robot.group('arm')) == 'slide'
    assert moved_links(robot, 'arm') == {'upper', 'lower', 'slide'}
    assert moved_links(robot, 'end') == {'slide'}
