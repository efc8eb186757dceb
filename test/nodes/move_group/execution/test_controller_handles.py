# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How goals of controllers end, and what they are sent."""

from types import SimpleNamespace

from action_msgs.msg import GoalStatus
from control_msgs.action import FollowJointTrajectory, GripperCommand, ParallelGripperCommand
import numpy as np
import pytest
from rclpy.task import Future

from armsim_ros.config.trajectory_execution import MoveItControllerSettings
from armsim_ros.errors import PlanningError
from armsim_ros.execution.controller_selection import MultiDofTrajectory
from armsim_ros.nodes.conversions.trajectory import multi_dof_from_message
from armsim_ros.nodes.move_group.execution.controller_actions import action_of
from armsim_ros.nodes.move_group.execution.controller_handles import ControllerRun
from armsim_ros.trajectory import JointTrajectory

SUCCEEDED, ABORTED, CANCELED = (
    GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_ABORTED, GoalStatus.STATUS_CANCELED)
CLOSING = JointTrajectory(
    ('finger',), np.array([0.0, 1.0]), np.array([[0.0], [0.02]]), effort=np.array([[0.0], [4.0]]))
DRIVE = MultiDofTrajectory(
    ('base',), np.array([0.0, 1.0]), np.arange(14.0).reshape(2, 1, 7),
    np.arange(12.0).reshape(2, 1, 6), 5_000_000_000)


def action(kind, **options):
    """Return a controller's action."""
    settings = MoveItControllerSettings(
        name='hand', type=kind, action_ns='', joints=('finger',), **options)
    return action_of(settings, lambda _: None)


def ended(kind, status, result, **options):
    """Return a goal that has ended."""
    sent, answer = Future(), Future()
    used = action(kind, **options)
    controller = SimpleNamespace(settings=used.settings, action=used)
    run = ControllerRun(sent, controller, lambda: None)
    sent.set_result(SimpleNamespace(accepted=True, get_result_async=lambda: answer))
    answer.set_result(SimpleNamespace(status=status, result=result))
    return run


@pytest.mark.parametrize('kind', ['GripperCommand', 'ParallelGripperCommand'])
def test_the_status_decides(kind):
    """
    A gripper's goal that succeeded is a success although it stalled, whatever its result has.

    Upstream: action_based_controller_handle.hpp, finishControllerExecution.
    """
    message = action(kind).type
    stalled = message.Result(stalled=True, reached_goal=False)
    assert not ended(kind, SUCCEEDED, stalled).failed
    assert not ended(kind, SUCCEEDED, message.Result()).failed
    arrived = message.Result(reached_goal=True)
    assert ended(kind, ABORTED, arrived).failed
    assert ended(kind, ABORTED, stalled).failure == 'the gripper stalled'
    assert ended(kind, CANCELED, stalled).canceled


def test_a_trajectorys_error_code_does_not_decide():
    """
    The status of a FollowJointTrajectory goal decides; code and sentence are reported.

    Upstream: follow_joint_trajectory_controller_handle.cpp, controllerDoneCallback.
    """
    odd = FollowJointTrajectory.Result(error_code=-5, error_string='late')
    assert not ended('FollowJointTrajectory', SUCCEEDED, odd).failed
    assert ended('FollowJointTrajectory', ABORTED, odd).failure == 'late'
    bare = FollowJointTrajectory.Result()
    assert ended('FollowJointTrajectory', ABORTED, bare).failure == f'goal status {ABORTED}'


def test_allowed_failure():
    """
    With allow_failure an aborted GripperCommand is a success; a cancelled one is not.

    Upstream: gripper_command_controller_handle.hpp, controllerDoneCallback.
    """
    result = GripperCommand.Result(stalled=True)
    assert not ended('GripperCommand', ABORTED, result, allow_failure=True).failed
    assert ended('GripperCommand', CANCELED, result, allow_failure=True).failed
    other = ParallelGripperCommand.Result()
    assert ended('ParallelGripperCommand', ABORTED, other, allow_failure=True).failed


def test_commands_of_grippers():
    """
    Efforts are the last point's, or the parameter's; ParallelGripperCommand has those above 0.

    Upstream: gripper_command_controller_handle.hpp and
    parallel_gripper_command_controller_handle.hpp, sendTrajectory.
    """
    goal = action('GripperCommand', max_effort=9.0).goal(CLOSING, None)
    assert (goal.command.position, goal.command.max_effort) == (0.02, 4.0)
    bare = JointTrajectory(CLOSING.joint_names, CLOSING.times, CLOSING.positions)
    assert action('GripperCommand', max_effort=9.0).goal(bare, None).command.max_effort == 9.0
    command = action('ParallelGripperCommand', max_velocity=0.1).goal(CLOSING, None).command
    assert (list(command.name), list(command.position)) == (['finger'], [0.02])
    assert (list(command.velocity), list(command.effort)) == ([0.1], [])
    command = action('ParallelGripperCommand', max_effort=3.0).goal(CLOSING, None).command
    assert (list(command.velocity), list(command.effort)) == ([], [3.0])


@pytest.mark.parametrize('kind', ['GripperCommand', 'ParallelGripperCommand'])
def test_grippers_have_one_degree_of_freedom(kind):
    """
    A gripper's controller refuses multi-DOF points.

    Upstream: gripper_command_controller_handle.hpp, sendTrajectory.
    """
    with pytest.raises(PlanningError, match='cannot run multi-DOF'):
        action(kind).goal(JointTrajectory(()), DRIVE)


def test_multi_dof_points_reach_the_controller():
    """
    FollowJointTrajectory has the multi-DOF points beside those of the joints, headers unchanged.

    Upstream: follow_joint_trajectory_controller_handle.cpp, sendTrajectory.
    """
    goal = action('FollowJointTrajectory').goal(JointTrajectory((), stamp_ns=7), DRIVE)
    assert not goal.trajectory.points
    assert goal.trajectory.header.stamp.nanosec == 7
    again = multi_dof_from_message(goal.multi_dof_trajectory)
    assert (again.joint_names, again.stamp_ns) == (('base',), 5_000_000_000)
    assert again.transforms.tolist() == DRIVE.transforms.tolist()
    assert again.velocities.tolist() == DRIVE.velocities.tolist()
