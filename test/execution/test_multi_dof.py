# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of trajectories of planar and floating joints."""

from dataclasses import replace
import math

import numpy as np
import pytest

from armsim_ros.errors import PlanningError
from armsim_ros.execution.controller_selection import (
    as_joint_trajectory,
    controlled_joints,
    MultiDofTrajectory,
)
from armsim_ros.model.semantic_model import VirtualJoint
from armsim_ros.trajectory import JointTrajectory


@pytest.fixture(scope='module')
def mobile(planar):
    """Return the planar arm on a base that drives."""
    base = VirtualJoint('base', 'planar', 'world', planar.robot.root_link)
    return replace(planar.robot, semantic=replace(planar.robot.semantic, virtual_joint=base))


DRIVE = MultiDofTrajectory(
    ('base',), np.array([0.0, 1.0]),
    np.array([[[0, 0, 0, 0, 0, 0, 1.0]], [[1, 2, 0, 0, 0, math.sin(0.25), math.cos(0.25)]]]),
    np.ones((2, 1, 6)))


def test_multi_dof_joints_need_a_controller(planar, mobile):
    """
    A multi-DOF joint and its variables are among the joints that a controller has to move.

    Upstream: trajectory_execution_manager.cpp, configure.
    """
    assert controlled_joints(('axis1', 'base'), mobile) == ('axis1', 'base')
    assert controlled_joints(('base/theta',), mobile) == ('base/theta',)
    with pytest.raises(PlanningError, match="'base', which robot"):
        controlled_joints(('base',), planar.robot)


def test_variables_beside_the_joints(mobile):
    """
    With control_multi_dof_joint_variables the variables are joints of the trajectory.

    Upstream: trajectory_execution_manager.cpp, push; robot_trajectory.cpp, toJointTrajectory.
    """
    arm = JointTrajectory(('axis1',), np.array([0.0, 1.0]), np.array([[0.0], [0.3]]))
    whole = as_joint_trajectory(arm, DRIVE, mobile)
    assert whole.joint_names == ('axis1', 'base/x', 'base/y', 'base/theta')
    assert whole.positions[1] == pytest.approx([0.3, 1.0, 2.0, 0.5])
    assert as_joint_trajectory(JointTrajectory(()), DRIVE, mobile).joint_names[0] == 'base/x'


def test_what_does_not_fit_is_refused(planar, mobile):
    """A joint that has no such variables, or another number of points, is refused."""
    with pytest.raises(PlanningError, match='multi-DOF joints of the robot: none'):
        as_joint_trajectory(JointTrajectory(()), DRIVE, planar.robot)
    with pytest.raises(PlanningError, match='2 points beside 1'):
        as_joint_trajectory(
            JointTrajectory(('axis1',), np.zeros(1), np.zeros((1, 1))), DRIVE, mobile)


def test_velocities_are_scaled():
    """
    The velocities of a part are multiplied by execution_velocity_scaling.

    Upstream: trajectory_execution_manager.cpp, distributeTrajectory.
    """
    assert DRIVE.of_joints(('base',), 0.5).velocities.tolist() == np.full((2, 1, 6), 0.5).tolist()
