# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which controllers get a trajectory, and what they get of it; the test plays them."""

from __future__ import annotations

import re

from geometry_msgs.msg import Transform
from move_group_bench import ABORTED
from moveit_msgs.msg import RobotTrajectory
from played_stand import allowed, LOWER, Stand, START, UPPER
import pytest
from trajectory_msgs.msg import MultiDOFJointTrajectoryPoint


@pytest.mark.statement('EXE-3')
def test_the_fewest_controllers_are_chosen(stand: Stand) -> None:
    """One controller for five joints rather than two."""
    assert stand.arm.execute(stand.trajectory(*LOWER, *UPPER)).code == 'SUCCESS'
    assert [len(one.goals) for one in stand.all] == [0, 0, 1, 0]


@pytest.mark.statement('EXE-3')
def test_the_one_with_fewer_surplus_joints_is_chosen(stand: Stand) -> None:
    """Two joints go to the controller that has no others."""
    assert stand.arm.execute(stand.trajectory(*UPPER)).code == 'SUCCESS'
    assert [len(one.goals) for one in stand.all] == [0, 1, 0, 0]


@pytest.mark.statement('EXE-3', 'EXE-4', 'ACT-12', 'EXE-11')
def test_a_trajectory_is_split(stand: Stand) -> None:
    """Each controller gets its own joints at the same times, from now on."""
    trajectory = stand.trajectory(*LOWER, *UPPER)
    assert stand.arm.execute(trajectory, ['lower', 'upper']).code == 'SUCCESS'
    (one,), (two,) = stand.lower.goals, stand.upper.goals
    assert list(one.trajectory.joint_names) == list(LOWER)
    assert list(two.trajectory.joint_names) == list(UPPER)
    for goal in (one, two):
        assert goal.trajectory.header.stamp.sec == 0
        assert not goal.path_tolerance
        assert not goal.goal_tolerance
        assert [p.time_from_start for p in goal.trajectory.points] == [
            p.time_from_start for p in trajectory.points
        ]


@pytest.mark.statement('EXE-1', 'EXE-4')
def test_a_gripper_gets_the_last_position(stand: Stand) -> None:
    """GripperCommand: the command joint's last position."""
    trajectory = stand.trajectory()
    assert stand.arm.execute(trajectory).code == 'SUCCESS'
    (goal,) = stand.hand.goals
    place = list(trajectory.joint_names).index('joint_6')
    assert goal.command.position == pytest.approx(trajectory.points[-1].positions[place])


@pytest.mark.statement('EXE-3', 'E14', 'SEED-9')
def test_controllers_that_do_not_cover_the_joints(stand: Stand) -> None:
    """-4 with the sentence that users search for, and the known controllers."""
    ended = stand.arm.execute(stand.trajectory(*LOWER), ['upper'])
    text = ended.result.error_code.message
    assert (ended.status, ended.code) == (ABORTED, 'CONTROL_FAILED')
    assert 'Unable to identify any set of controllers that can actuate the specified' in text
    assert 'Known controllers and their joints:' in text
    stand.server.program.wait_for_line('Known controllers and their joints:')


@pytest.mark.statement('EXE-5')
def test_tolerance_of_one_joint(stand: Stand) -> None:
    """The start of one joint may be further away than that of the others."""
    trajectory = stand.trajectory(*UPPER)
    stand.move('joint_4', 0.1)
    ended = stand.arm.execute(trajectory)
    assert ended.code == 'CONTROL_FAILED'
    assert 'joint_4' in ended.result.error_code.message
    name = 'trajectory_execution.allowed_start_tolerance_joints.joint_4'
    assert stand.arm.execution_parameters.set(name, 0.2) == ''
    assert stand.arm.execute(trajectory).code == 'SUCCESS'
    assert stand.arm.execution_parameters.set(name, 0.01) == ''


@pytest.mark.statement('S20', 'PAR-4', 'EXE-1')
def test_controllers_are_parameters(stand: Stand) -> None:
    """
    The controllers without faults are parameters; a faulty one is reported and left out.

    Upstream: moveit_simple_controller_manager.cpp, initialize.
    """
    manager = 'moveit_simple_controller_manager'
    for parameters in (stand.arm.parameters, stand.arm.execution_parameters):
        get = parameters.get
        assert get(f'{manager}.controller_names') == ['lower', 'upper', 'whole', 'hand', 'absent']
        assert get(f'{manager}.hand.action_ns') == 'gripper_cmd'
        assert get(f'{manager}.upper.allowed_goal_duration_margin') == 0.3
    stand.server.program.wait_for_line("'faulty' has no 'action_ns'")


@pytest.mark.statement('S19')
def test_parameters_count_on_the_controller_managers_node(stand: Stand) -> None:
    """
    move_group takes trajectory_execution.* without effect; others than these are refused.

    Upstream: trajectory_execution_manager.cpp, initialize.
    """
    name = 'trajectory_execution.allowed_start_tolerance'
    assert stand.arm.parameters.set(name, 5.0) == ''
    stand.server.program.wait_for_line('no effect on this node')
    trajectory = stand.trajectory(*UPPER)
    stand.move('joint_4', 0.1)
    assert stand.arm.execute(trajectory).code == 'CONTROL_FAILED'
    refused = stand.arm.execution_parameters.set
    assert 'not known' in refused('anything', 1)
    assert "no joint 'elbow'" in refused(f'{name}_joints.elbow', 0.1)
    assert 'from 0 up' in refused(f'{name}_joints.joint_4', -0.1)


@pytest.mark.statement('S18')
def test_velocity_scaling_at_run_time(stand: Stand) -> None:
    """
    The velocities of the points are multiplied, nothing else.

    Upstream: trajectory_execution_manager.cpp, distributeTrajectory.
    """
    name = 'trajectory_execution.execution_velocity_scaling'
    trajectory = stand.trajectory(*UPPER)
    assert stand.arm.execution_parameters.set(name, 0.5) == ''
    assert stand.arm.execute(trajectory).code == 'SUCCESS'
    assert stand.arm.execution_parameters.set(name, 1.0) == ''
    (goal,) = stand.upper.goals
    for sent, given in zip(goal.trajectory.points, trajectory.points, strict=True):
        assert list(sent.velocities) == pytest.approx([0.5 * each for each in given.velocities])
        assert list(sent.positions) == pytest.approx(list(given.positions))
        assert sent.time_from_start == given.time_from_start


@pytest.mark.statement('S12')
def test_joint_states_that_have_stopped(stand: Stand) -> None:
    """
    Without a joint state newer than the request nothing is started: -4.

    Upstream: trajectory_execution_manager.cpp, validate.
    """
    trajectory = stand.trajectory(*UPPER)
    stand.played.silence()
    try:
        ended = stand.arm.execute(trajectory)
    finally:
        stand.played.resume()
    assert ended.code == 'CONTROL_FAILED'
    assert 'no joint state newer' in ended.result.error_code.message
    assert not stand.upper.goals


@pytest.mark.statement('S15')
def test_a_trajectory_with_a_stamp(stand: Stand) -> None:
    """
    The header reaches the controller; the time until its stamp belongs to the allowed duration.

    Upstream: trajectory_execution_manager.cpp, distributeTrajectory and executePart.
    """
    stand.upper.behaviour = 'hold'
    trajectory = stand.trajectory(*UPPER)
    late = stand.server.client.node.get_clock().now().nanoseconds + 2_000_000_000
    stamp = trajectory.header.stamp
    stamp.sec, stamp.nanosec = divmod(late, 10**9)
    ended = stand.arm.execute(trajectory)
    (goal,) = stand.upper.goals
    assert goal.trajectory.header.stamp == stamp
    assert ended.code == 'TIMED_OUT'
    (told,) = re.findall(r'longer than the ([0-9.]+) s', ended.result.error_code.message)
    assert allowed(trajectory) + 1.0 < float(told) < allowed(trajectory) + 2.5


@pytest.mark.statement('S16')
def test_multi_dof_points_need_a_controller(stand: Stand) -> None:
    """
    A trajectory with multi-DOF points is not empty: without a controller for them it is -4.

    Upstream: trajectory_execution_manager.cpp, configure.
    """
    whole = RobotTrajectory()
    whole.multi_dof_joint_trajectory.joint_names = ['base']
    whole.multi_dof_joint_trajectory.points = [
        MultiDOFJointTrajectoryPoint(transforms=[Transform()])]
    ended = stand.arm.execute(whole)
    assert (ended.status, ended.code) == (ABORTED, 'CONTROL_FAILED')
    assert "'base'" in ended.result.error_code.message
    assert stand.arm.execute(RobotTrajectory()).code == 'SUCCESS'


@pytest.mark.statement('BOOT-5', 'E12')
def test_missing_acceleration_limits_do_not_hinder(stand: Stand) -> None:
    """A default is assumed and told once, in one line that names the joints."""
    for step in (0.1, 0.2):
        stand.arm.planned({name: value + step for name, value in START.items()})
    lines = [line for line in stand.server.program.output if 'no acceleration limit' in line]
    assert len(lines) == 1
    assert all(name in lines[0] for name in START)
