# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Point-to-point, linear and circular commands."""

from __future__ import annotations

from dataclasses import replace
import time
from typing import Any

import numpy as np
import pytest

from armsim_ros.config.ompl_planning import PipelineSettings, PlanningParameters
from armsim_ros.config.pipeline_defaults import PILZ_PLUGIN
from armsim_ros.errors import MoveItErrorCode
from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_from_parts, pose_matrix
from armsim_ros.planning.context import settings_from_config
from armsim_ros.planning.planner import MotionPlanner
from armsim_ros.planning.request import Constraints, JointConstraint
from armsim_ros.planning.scene.objects import CollisionObject, ObjectShape

GROUP, TIP = 'manipulator', 'tool0'
START = (0.3, -0.9, 1.2, 0.2, 0.9, 0.1)


def test_ptp_starts_and_stops_all_joints_together(bench: Any) -> None:
    """PLZ-5: every joint is at the same share of its way at every time."""
    goal = np.array(START) * 0.5
    answer = bench.run('PTP', bench.joints(goal))
    assert answer.success, answer.message
    share = (answer.trajectory.positions - START) / (goal - START)
    assert np.ptp(share, axis=1).max() < 1e-9
    assert share[-1] == pytest.approx(np.ones(6))


def test_ptp_uses_the_smallest_limits_of_all_joints(bench: Any) -> None:
    """
    The joint with the longest way moves with the smallest velocity and acceleration limit.

    pilz, trajectory_generator_ptp.cpp, planPTP.
    """
    goal = np.add(START, (0.2, 0.0, 0.0, 0.0, 0.0, 1.5))
    answer = bench.run('PTP', bench.joints(goal), max_acceleration_scaling_factor=0.5)
    index = bench.model.group_indices(GROUP)
    speed = 0.1 * bench.model.velocity_limits[index].min()
    rate = 0.5 * bench.model.acceleration_limits[index].min()
    assert bench.model.velocity_limits[index[-1]] > bench.model.velocity_limits[index].min()
    assert answer.trajectory.duration == pytest.approx(1.5 / speed + speed / rate)
    assert np.abs(answer.trajectory.velocities).max() == pytest.approx(speed)
    assert np.abs(answer.trajectory.accelerations).max() == pytest.approx(rate)


def test_ptp_at_its_goal_is_one_point(bench: Any) -> None:
    """
    A goal within 1 mrad of the start in every joint gives the start at 0.1 s.

    pilz, trajectory_generator_ptp.cpp, planPTP.
    """
    answer = bench.run('PTP', bench.joints(np.array(START) + 0.0009))
    assert answer.success, answer.message
    assert answer.trajectory.times.tolist() == [0.1]
    assert answer.trajectory.positions[0] == pytest.approx(START)
    assert not answer.trajectory.velocities.any()


def test_ptp_of_some_joints_leaves_the_others(bench: Any) -> None:
    """
    A joint goal of a PTP need not name all joints.

    pilz, trajectory_generator_ptp.cpp, extractMotionPlanInfo.
    """
    goal = Constraints(joint_constraints=(JointConstraint(bench.names[2], 1.0),))
    answer = bench.run('PTP', goal)
    assert answer.trajectory.positions[-1] == pytest.approx((*START[:2], 1.0, *START[3:]))


def test_goal_of_a_ptp_may_touch_objects_before_validation(bench: Any) -> None:
    """
    The goal state is that of the start's own posture; an object in it makes the plan fail.

    pilz, trajectory_functions.cpp, isStateColliding.
    """
    wanted = bench.moved(0.0, 0.1, 0.0)
    bench.scene.apply_object(CollisionObject(
        'post', pose=pose_from_parts(wanted[:3, 3] - (0.0, 0.0, 0.02), np.eye(3)),
        shapes=(ObjectShape(Box((0.05, 0.05, 0.01)), np.eye(4)),)))
    assert bench.run('PTP', bench.at(wanted)).error_code == MoveItErrorCode.INVALID_MOTION_PLAN


def test_ptp_reaches_a_pose(bench: Any) -> None:
    """A pose goal is brought to joint positions first."""
    wanted = bench.moved(0.1, 0.1, -0.1)
    answer = bench.run('PTP', bench.at(wanted))
    assert answer.success, answer.message
    assert bench.tips(answer.trajectory)[-1] == pytest.approx(wanted[:3, 3], abs=1e-4)


def test_lin_is_straight(bench: Any) -> None:
    """PLZ-3: the link stays within 1 mm of the line, between the points too."""
    wanted = bench.moved(-0.1, 0.15, -0.05)
    answer = bench.run('LIN', bench.at(wanted))
    assert answer.success, answer.message
    way = wanted[:3, 3] - bench.pose[:3, 3]
    way /= np.linalg.norm(way)
    off = bench.tips(answer.trajectory) - bench.pose[:3, 3]
    assert np.abs(off - np.outer(off @ way, way)).max() < 1e-3
    assert off[-1] == pytest.approx(wanted[:3, 3] - bench.pose[:3, 3], abs=1e-4)


@pytest.mark.parametrize('command', ['LIN', 'PTP'])
def test_points_are_a_tenth_of_a_second_apart(bench: Any, command: str) -> None:
    """
    Points at multiples of 0.1 s and one at the end; rest at both ends.

    pilz, trajectory_functions.cpp, generateJointTrajectory; trajectory_generator_ptp.cpp, planPTP.
    """
    trajectory = bench.run(command, bench.at(bench.moved(-0.1, 0.15, -0.05))).trajectory
    assert np.diff(trajectory.times)[:-1] == pytest.approx(0.1)
    assert 0.0 < np.diff(trajectory.times)[-1] <= 0.1 + 1e-9
    for quantity in (trajectory.velocities, trajectory.accelerations):
        assert not quantity[0].any()
        assert not quantity[-1].any()


def test_lin_has_velocities_of_finite_differences(bench: Any) -> None:
    """
    Velocity and acceleration of a point are differences to the points before it.

    pilz, trajectory_functions.cpp, generateJointTrajectory.
    """
    trajectory = bench.run('LIN', bench.at(bench.moved(-0.1, 0.15, -0.05))).trajectory
    speed = np.diff(trajectory.positions, axis=0) / np.diff(trajectory.times)[:, None]
    assert trajectory.velocities[1:-1] == pytest.approx(speed[:-1])
    rate = np.diff(trajectory.velocities[:-1], axis=0) / 0.1
    assert trajectory.accelerations[1:-1] == pytest.approx(rate)


def test_lin_lasts_as_long_as_the_cartesian_limits_demand(bench: Any) -> None:
    """
    A trapezoid of max_trans_vel and max_trans_acc; braking uses the acceleration too.

    pilz, trajectory_generator.cpp, cartesianTrapVelocityProfile.
    """
    tool = bench.planner.settings.cartesian_limits
    speed, rate = 0.05 * tool.max_trans_vel, 0.1 * tool.max_trans_acc
    answer = bench.run('LIN', bench.at(bench.moved(0.0, 0.15, 0.0)),
                       max_velocity_scaling_factor=0.05)
    assert answer.trajectory.duration == pytest.approx(0.15 / speed + speed / rate, abs=1e-6)


def test_rotation_counts_as_length(bench: Any) -> None:
    """
    A turn on the spot lasts as long as a way of angle * max_trans_vel / max_rot_vel.

    pilz, trajectory_generator_lin.cpp, setPathLIN.
    """
    tool = bench.planner.settings.cartesian_limits
    wanted = bench.pose @ pose_matrix((0.0, 0.0, 0.0), (0.0, 0.0, 0.6))
    speed, rate = 0.1 * tool.max_trans_vel, 0.1 * tool.max_trans_acc
    answer = bench.run('LIN', bench.at(wanted))
    way = 0.6 * tool.max_trans_vel / tool.max_rot_vel
    assert answer.trajectory.duration == pytest.approx(way / speed + speed / rate, abs=1e-5)


def test_lin_to_the_start_is_one_point(bench: Any) -> None:
    """
    A line without length is a success with one point at rest.

    pilz, trajectory_generator.cpp, cartesianTrapVelocityProfile.
    """
    answer = bench.run('LIN', bench.joints(START))
    assert answer.success, answer.message
    assert answer.trajectory.positions == pytest.approx(np.array([START]), abs=1e-5)


def test_lin_through_a_singularity(bench: Any) -> None:
    """
    Where joints would have to race or to jump to another posture the line is refused: -1.

    pilz, trajectory_functions.cpp, verifySampleJointLimits.
    """
    goal = bench.at(bench.moved(0.15, -0.2, 0.35))
    assert bench.run('PTP', goal).success
    assert bench.run('LIN', goal).error_code == MoveItErrorCode.PLANNING_FAILED


def test_lin_to_joint_positions(bench: Any) -> None:
    """
    A joint goal of a LIN is a line of the solver's tip, and names every joint.

    pilz, trajectory_generator_lin.cpp, extractMotionPlanInfo.
    """
    goal = np.add(START, (0.1, 0.05, -0.1, 0.0, 0.05, 0.1))
    answer = bench.run('LIN', bench.joints(goal))
    assert answer.success, answer.message
    assert answer.trajectory.positions[-1] == pytest.approx(goal, abs=1e-4)
    answer = bench.run('LIN', bench.joints(goal[:5]))
    assert answer.error_code == MoveItErrorCode.INVALID_GOAL_CONSTRAINTS


def test_circ_through_an_interim_point(bench: Any) -> None:
    """PLZ-4: the link goes through the interim point on a circle."""
    interim, wanted = bench.moved(-0.05, 0.05, 0.0), bench.moved(0.0, 0.1, 0.0)
    through = bench.at(interim, name='interim')
    answer = bench.run('CIRC', bench.at(wanted), path_constraints=through)
    assert answer.success, answer.message
    center = bench.pose[:3, 3] + [0.0, 0.05, 0.0]
    tips = bench.tips(answer.trajectory)
    assert np.linalg.norm(tips - center, axis=1) == pytest.approx(0.05, abs=1e-3)
    assert np.linalg.norm(tips - interim[:3, 3], axis=1).min() < 2e-3


def test_circ_takes_the_long_way_round(bench: Any) -> None:
    """
    An interim point on the far side makes an arc of more than half a circle.

    pilz, path_circle_generator.cpp, circleFromInterim.
    """
    interim, wanted = bench.moved(-0.06, 0.03, 0.0), bench.moved(0.0, 0.06, 0.0)
    answer = bench.run('CIRC', bench.at(wanted),
                       path_constraints=bench.at(interim, name='interim'))
    assert answer.success, answer.message
    way = np.linalg.norm(np.diff(bench.tips(answer.trajectory), axis=0), axis=1).sum()
    radius = (0.06**2 + 0.03**2) / (2.0 * 0.06)
    assert way == pytest.approx(2.0 * radius * (np.pi - np.arcsin(0.03 / radius)), rel=1e-2)


def test_circ_to_joint_positions(bench: Any) -> None:
    """
    The arc of a joint goal is that of the link that the path constraint names.

    pilz, trajectory_generator_circ.cpp, extractMotionPlanInfo.
    """
    wanted = bench.moved(-0.08, 0.08, 0.0)
    goal = bench.joints(bench.run('PTP', bench.at(wanted)).trajectory.positions[-1])
    center = bench.moved(0.0, 0.08, 0.0)
    answer = bench.run('CIRC', goal, path_constraints=bench.at(center, name='center'))
    assert answer.success, answer.message
    tips = bench.tips(answer.trajectory)
    assert np.linalg.norm(tips - center[:3, 3], axis=1) == pytest.approx(0.08, abs=1e-3)
    unknown = bench.run('CIRC', goal, path_constraints=bench.at(center, 'nowhere', 'center'))
    assert unknown.error_code == MoveItErrorCode.INVALID_LINK_NAME


def test_offset_of_a_pose_goal_shifts_the_arc_too(bench: Any) -> None:
    """
    target_point_offset of the goal is taken off the goal and off the centre.

    pilz, trajectory_generator_circ.cpp, extractMotionPlanInfo.
    """
    offset = (0.0, 0.0, 0.05)
    shift = bench.pose[:3, :3] @ offset
    center, wanted = bench.moved(0.0, 0.08, 0.0), bench.moved(-0.08, 0.08, 0.0)
    plain = bench.run('CIRC', bench.at(wanted), path_constraints=bench.at(center, name='center'))
    goal = bench.at(pose_from_parts(wanted[:3, 3] + shift, wanted[:3, :3]))
    goal = replace(goal, position_constraints=(
        replace(goal.position_constraints[0], target_point_offset=offset),))
    moved = bench.at(pose_from_parts(center[:3, 3] + shift, np.eye(3)), name='center')
    shifted = bench.run('CIRC', goal, path_constraints=moved)
    assert shifted.success, shifted.message
    assert shifted.trajectory.positions == pytest.approx(plain.trajectory.positions, abs=1e-4)


def test_circ_about_a_center(bench: Any) -> None:
    """PLZ-4: the shorter arc about the centre."""
    center, wanted = bench.moved(0.0, 0.08, 0.0), bench.moved(-0.08, 0.08, 0.0)
    answer = bench.run('CIRC', bench.at(wanted), path_constraints=bench.at(center, name='center'))
    assert answer.success, answer.message
    tips = bench.tips(answer.trajectory)
    assert np.linalg.norm(tips - center[:3, 3], axis=1) == pytest.approx(0.08, abs=1e-3)


@pytest.mark.parametrize(('tolerance', 'code'), [
    (0.5, MoveItErrorCode.SUCCESS), (0.01, MoveItErrorCode.INVALID_MOTION_PLAN)])
@pytest.mark.parametrize('kind', ['joint', 'orientation'])
def test_circ_keeps_constraints_beside_its_auxiliary_point(
    bench: Any, kind: str, tolerance: float, code: MoveItErrorCode
) -> None:
    """
    Joint and orientation constraints beside the auxiliary point are verified on the path.

    moveit_ros, validate_path.cpp, adapt.
    """
    wanted = bench.moved(-0.08, 0.08, 0.0)
    wanted[:3, :3] = pose_matrix((0.0, 0.0, 0.0), (0.0, 0.0, 0.3))[:3, :3] @ wanted[:3, :3]
    kept = bench.at(bench.moved(0.0, 0.08, 0.0), name='center')
    if kind == 'joint':
        kept = replace(kept, joint_constraints=(
            JointConstraint(bench.names[0], START[0], tolerance, tolerance),))
    else:
        orientation, = bench.at(bench.pose).orientation_constraints
        kept = replace(kept, orientation_constraints=(
            replace(orientation, tolerances=(tolerance,) * 3),))
    answer = bench.run('CIRC', bench.at(wanted), path_constraints=kept)
    assert answer.error_code == code, answer.message


def test_unreachable_goal(bench: Any) -> None:
    """PLZ-3: a pose out of reach is -31, and the message names link and position."""
    goal = bench.moved(5.0, 0.0, 0.0)
    answer = bench.run('LIN', bench.at(goal))
    assert answer.error_code == MoveItErrorCode.NO_IK_SOLUTION
    assert f"put 'tool0' at {np.round(goal[:3, 3], 4).tolist()} m" in answer.message


def test_too_fast_for_a_joint(bench: Any) -> None:
    """
    A joint limit that the differences between points exceed is -1 and names the joint.

    pilz, trajectory_functions.cpp, verifySampleJointLimits.
    """
    answer = bench.run('LIN', bench.at(bench.moved(-0.1, 0.3, -0.1)),
                       max_velocity_scaling_factor=1.0, max_acceleration_scaling_factor=1.0)
    assert answer.error_code == MoveItErrorCode.PLANNING_FAILED
    assert '_joint' in answer.message


def test_obstacles_are_not_avoided_but_seen(bench: Any) -> None:
    """PLZ-6: a command whose way is blocked is -2."""
    wanted = bench.moved(-0.1, 0.3, -0.1)
    middle = 0.5 * (bench.pose + wanted)
    bench.scene.apply_object(CollisionObject(
        'post', pose=pose_from_parts(middle[:3, 3], np.eye(3)),
        shapes=(ObjectShape(Box((0.02, 0.02, 0.02)), np.eye(4)),)))
    answer = bench.run('LIN', bench.at(wanted))
    assert answer.error_code == MoveItErrorCode.INVALID_MOTION_PLAN
    assert "'post'" in answer.message
    assert answer.source == 'ValidateSolution'
    assert any('post' in (each.body1, each.body2) for each in answer.contacts)


def test_the_plugin_of_a_pipeline_makes_it_run_commands(bench: Any) -> None:
    """
    A pipeline of Pilz's plugin runs its commands under any name.

    Upstream: planning_pipeline.cpp, configure; prbt_moveit_config, demo.launch.py.
    """
    planner = MotionPlanner(bench.scene, settings=settings_from_config(
        PlanningParameters(planning_pipelines=('pilz', 'ompl')),
        {'pilz': PipelineSettings(planning_plugins=(PILZ_PLUGIN,)), 'ompl': PipelineSettings()},
        {}))
    goal = bench.at(bench.moved(0.0, 0.15, 0.1))
    answer = planner.plan(
        bench.request('LIN', goal, pipeline_id='pilz'), bench.scene.snapshot(),
        clock=time.monotonic)
    assert np.array_equal(
        answer.trajectory.positions, bench.run('LIN', goal).trajectory.positions)


def test_max_cartesian_speed_slows_a_command(bench: Any) -> None:
    """REQ-12: the tip is no faster than max_cartesian_speed."""
    answer = bench.run('PTP', bench.at(bench.moved(-0.1, 0.3, 0.1)), max_cartesian_speed=0.02)
    tips = bench.tips(answer.trajectory)
    step = answer.trajectory.duration / (len(tips) - 1)
    assert (np.linalg.norm(np.diff(tips, axis=0), axis=1) / step).max() < 0.0205


def test_max_cartesian_speed_where_nothing_moves(bench: Any) -> None:
    """REQ-12: a command to where the arm is succeeds with a limit as it does without."""
    answer = bench.run('PTP', bench.at(bench.pose), max_cartesian_speed=0.02)
    assert answer.error_code == MoveItErrorCode.SUCCESS
    assert answer.trajectory.duration == bench.run('PTP', bench.at(bench.pose)).trajectory.duration
