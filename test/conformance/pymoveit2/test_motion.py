# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Motions as a user of pymoveit2 asks for them, synchronously and not."""

from __future__ import annotations

import math
from typing import Any

from arm_user import angle, distance, positions, reached, TIMEOUT, until, xyz
from pymoveit2 import MoveIt2, MoveIt2State
import pytest
from rclpy.task import Future


def state(user: Any, name: str) -> list[float]:
    """Return a named state of the arm's group [rad]."""
    return list(user.description.joint_positions(name))


def go(arm: MoveIt2, target: list[float]) -> None:
    """Move to joint positions and be there."""
    assert arm.move_to_configuration(target), arm.last_failure()
    assert arm.wait_until_executed(TIMEOUT), arm.last_failure()
    assert distance(arm, target) < 0.01


@pytest.mark.statement('PM-3', 'PM-5', 'PM-6')
def test_a_joint_goal_is_reached(user: Any, arm: MoveIt2) -> None:
    """A joint goal with pymoveit2's own request: scaling 0, 0.5 s, five attempts."""
    go(arm, state(user, 'ready'))
    go(arm, state(user, 'left'))
    assert arm.motion_succeeded
    assert arm.get_last_execution_error_code().val == 1


@pytest.mark.statement('SEED-1')
def test_named_targets_are_reached(user: Any, arm: MoveIt2) -> None:
    """Group states of the SRDF, read from move_group's parameters, are goals."""
    for name in ('home', 'ready'):
        go(arm, state(user, name))


@pytest.mark.statement('PM-3', 'CON-7')
def test_a_pose_goal_is_reached(user: Any, arm: MoveIt2) -> None:
    """A pose of the end effector, given as position and quaternion."""
    go(arm, state(user, 'ready'))
    wanted = arm.compute_fk(state(user, 'left'))
    assert arm.move_to_pose(pose=wanted), arm.last_failure()
    assert arm.wait_until_executed(TIMEOUT), arm.last_failure()
    reached(arm, wanted, 5e-3, 1e-2)


@pytest.mark.statement('PM-5', 'SRV-33')
def test_a_cartesian_motion_is_straight(user: Any, planner: MoveIt2) -> None:
    """A Cartesian plan is complete, its points lie on the line, and it can be executed."""
    go(planner, state(user, 'ready'))
    start = planner.compute_fk()
    target = planner.compute_fk()
    target.pose.position.z -= 0.08
    trajectory = planner.plan(pose=target, cartesian=True, cartesian_fraction_threshold=0.999)
    assert trajectory is not None
    for point in trajectory.points[:: max(1, len(trajectory.points) // 10)]:
        pose = planner.compute_fk(list(point.positions)).pose.position
        assert math.hypot(pose.x - start.pose.position.x, pose.y - start.pose.position.y) < 1e-3
    assert planner.execute(trajectory)
    assert planner.wait_until_executed(TIMEOUT), planner.last_failure()
    reached(planner, target, 2e-3, 1e-2)


@pytest.mark.statement('PM-5')
def test_move_to_pose_goes_straight_where_asked(user: Any, planner: MoveIt2) -> None:
    """move_to_pose(cartesian=True) plans by the service and executes."""
    go(planner, state(user, 'ready'))
    target = planner.compute_fk()
    target.pose.position.x -= 0.05
    assert planner.move_to_pose(pose=target, cartesian=True, cartesian_fraction_threshold=0.999)
    assert planner.wait_until_executed(TIMEOUT), planner.last_failure()
    reached(planner, target, 2e-3, 1e-2)


@pytest.mark.statement('PM-5')
def test_a_plan_made_in_the_background_is_executed(user: Any, planner: MoveIt2) -> None:
    """plan_async, get_trajectory, execute and the execution's future."""
    go(planner, state(user, 'ready'))
    future = planner.plan_async(joint_positions=state(user, 'left'))
    assert isinstance(future, Future)
    until(future.done, 'the plan')
    trajectory = planner.get_trajectory(future)
    assert trajectory is not None
    assert distance(planner, state(user, 'ready')) < 0.01
    assert planner.execute(trajectory)
    assert planner.query_state() != MoveIt2State.IDLE
    until(lambda: planner.query_state() == MoveIt2State.IDLE, 'the end of the motion', TIMEOUT)
    assert planner.motion_succeeded, planner.last_failure()
    assert distance(planner, state(user, 'left')) < 0.01


@pytest.mark.statement('CON-1')
def test_goals_set_one_by_one_are_planned(user: Any, planner: MoveIt2) -> None:
    """set_joint_goal, set_pose_goal and alternatives by create_new_goal_constraint."""
    go(planner, state(user, 'ready'))
    planner.set_joint_goal(state(user, 'left'))
    trajectory = planner.plan()
    assert list(trajectory.points[-1].positions) == pytest.approx(state(user, 'left'), abs=2e-3)
    pose = planner.compute_fk(state(user, 'left'))
    planner.set_pose_goal(pose=pose)
    assert planner.plan() is not None
    planner.set_joint_goal([9.0] * 6)
    planner.create_new_goal_constraint()
    planner.set_joint_goal(state(user, 'left'))
    assert planner.plan() is not None


@pytest.mark.statement('CON-2', 'CON-3')
def test_position_and_orientation_goals_stand_alone(user: Any, planner: MoveIt2) -> None:
    """A position without an orientation, and an orientation without a position."""
    go(planner, state(user, 'ready'))
    wanted = planner.compute_fk(state(user, 'left'))
    planner.set_position_goal(wanted.pose.position, tolerance=0.002)
    trajectory = planner.plan()
    end = planner.compute_fk(list(trajectory.points[-1].positions)).pose.position
    assert math.dist(xyz(end), xyz(wanted.pose.position)) < 0.004
    planner.set_orientation_goal(wanted.pose.orientation, tolerance=0.01)
    assert planner.plan() is not None


@pytest.mark.statement('REQ-9')
def test_a_path_constraint_holds_all_along(user: Any, planner: MoveIt2) -> None:
    """An orientation constraint of the path holds at every point of the plan."""
    go(planner, state(user, 'ready'))
    start = planner.compute_fk()
    target = planner.compute_fk()
    target.pose.position.y += 0.12
    planner.set_path_orientation_constraint(start.pose.orientation, tolerance=0.2)
    planner.allowed_planning_time = 3.0
    trajectory = planner.plan(pose=target)
    assert trajectory is not None, planner.last_failure()
    for point in trajectory.points[:: max(1, len(trajectory.points) // 15)]:
        pose = planner.compute_fk(list(point.positions)).pose.orientation
        assert angle(pose, start.pose.orientation) < 0.2 * math.sqrt(3) + 1e-3


@pytest.mark.statement('PM-6', 'ACT-10', 'ACT-5')
def test_a_motion_is_cancelled(user: Any, arm: MoveIt2) -> None:
    """cancel_execution stops the arm; the next goal is reached again."""
    go(arm, state(user, 'home'))
    arm.max_velocity = 0.03
    assert arm.move_to_configuration(state(user, 'left'))
    until(lambda: distance(arm, state(user, 'home')) > 0.02, 'motion')
    assert arm.cancel_execution()
    assert not arm.wait_until_executed(TIMEOUT)
    assert arm.query_state() == MoveIt2State.IDLE
    assert not arm.motion_succeeded
    first, second = positions(arm), positions(arm)
    assert second == pytest.approx(first, abs=5e-3)
    assert distance(arm, state(user, 'left')) > 0.1
    arm.max_velocity = 0.0
    go(arm, state(user, 'ready'))


@pytest.mark.statement('SRV-72')
def test_everything_stops_by_the_event(user: Any, planner: MoveIt2) -> None:
    """stop_all_trajectory_execution ends the motion of another client's goal."""
    go(planner, state(user, 'home'))
    planner.max_velocity = 0.03
    assert planner.move_to_configuration(state(user, 'left'))
    until(lambda: distance(planner, state(user, 'home')) > 0.02, 'motion')
    user.arm().stop_all_trajectory_execution()
    assert not planner.wait_until_executed(TIMEOUT)
    assert 'stop' in planner.last_failure().lower()


@pytest.mark.statement('ERR-0.1')
def test_a_failure_names_its_reason(user: Any, planner: MoveIt2) -> None:
    """A pose out of reach: no trajectory, and the failure says more than a number."""
    far = planner.compute_fk(state(user, 'ready'))
    far.pose.position.x += 5.0
    assert not planner.move_to_pose(pose=far)
    assert planner.last_failure()


@pytest.mark.statement('PM-1')
def test_a_session_finds_the_robot_by_itself(user: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """connect() reads URDF and SRDF, and moves the arm that it finds."""
    from pymoveit2 import connect

    monkeypatch.setenv('ROS_DOMAIN_ID', str(user.node.context.get_domain_id()))
    with connect(args=user.remap) as session:
        assert session.arm.group_name == user.description.arm_group_name
        assert session.move_to_configuration(
            session.joint_positions('ready'), timeout_sec=TIMEOUT
        ), session.last_failure()
