# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of the commands of grippers."""

import numpy as np
import pytest

from armsim_ros.config.trajectory_execution import MoveItControllerSettings
from armsim_ros.errors import PlanningError
from armsim_ros.execution.controller_selection import gripper_target, parallel_gripper_target
from armsim_ros.trajectory import JointTrajectory


def hand(**options):
    """Return the controller of a hand with two fingers."""
    return MoveItControllerSettings(
        name='hand', type='GripperCommand', action_ns='gripper_cmd', joints=('left', 'right'),
        **options)


def closing(*names, effort=None):
    """Return a part in which the k-th joint goes from 0 to (k + 1) / 100."""
    last = [(k + 1) / 100 for k in range(len(names))]
    return JointTrajectory(
        names, np.array([0.0, 1.0]), np.array([[0.0] * len(names), last]),
        effort=None if effort is None else np.array([[np.nan] * len(names), effort]))


def test_the_command_joints_last_position():
    """
    The first joint is the command joint unless another one is named.

    Upstream: gripper_command_controller_handle.hpp, sendTrajectory.
    """
    assert gripper_target(closing('left', 'right'), hand()).position == 0.01
    assert gripper_target(closing('left', 'right'), hand(command_joint='right')).position == 0.02


def test_two_jaws_are_added():
    """
    With parallel the position is the sum of those of the two joints that the part has.

    Upstream: gripper_command_controller_handle.hpp, sendTrajectory.
    """
    jaws = hand(parallel=True)
    assert gripper_target(closing('left', 'right'), jaws).position == pytest.approx(0.03)
    assert gripper_target(closing('right'), jaws).position == 0.01


def test_effort_of_the_last_point():
    """
    The last point's effort counts where it is given, else that of the parameters.

    Upstream: gripper_command_controller_handle.hpp, sendTrajectory.
    """
    part = closing('left', 'right', effort=[5.0, 7.0])
    assert gripper_target(part, hand(max_effort=3.0)).effort == 5.0
    assert gripper_target(part, hand(command_joint='right')).effort == 7.0
    assert gripper_target(part, hand(parallel=True)).effort == 7.0
    assert gripper_target(closing('left'), hand(max_effort=3.0)).effort is None


def test_a_part_without_the_command_joint():
    """
    The first joint of the part stands in for a command joint that it lacks.

    Upstream: gripper_command_controller_handle.hpp, sendTrajectory.
    """
    target = gripper_target(closing('right'), hand(command_joint='left'))
    assert (target.joint, target.position, target.assumed) == ('right', 0.01, True)


def test_a_last_point_without_positions():
    """
    It is refused by the joint's name.

    Upstream: gripper_command_controller_handle.hpp, sendTrajectory.
    """
    part = JointTrajectory(('left',), np.array([0.0, 1.0]), np.array([[0.0], [np.nan]]))
    with pytest.raises(PlanningError, match="no position of joint 'left'"):
        gripper_target(part, hand())


def test_parallel_gripper_commands_its_first_joint():
    """
    A ParallelGripperCommand is for the first joint, and a part without it is refused.

    Upstream: moveit_simple_controller_manager.cpp, initialize, and
    parallel_gripper_command_controller_handle.hpp, sendTrajectory.
    """
    assert parallel_gripper_target(closing('left', 'right'), hand()).position == 0.01
    with pytest.raises(PlanningError, match="no joint 'left'"):
        parallel_gripper_target(closing('right'), hand())
