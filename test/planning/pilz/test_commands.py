# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Point-to-point, linear and circular commands."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest

from armsim_ros.errors import MoveItErrorCode
from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_from_parts
from armsim_ros.planning.pilz.profile import TrapezoidalProfile
from armsim_ros.planning.request import Constraints, JointConstraint, MotionPlanRequest
from armsim_ros.planning.scene.objects import CollisionObject, ObjectShape
from armsim_ros.planning.scene.update import StartState
from armsim_ros.quintic_motion import QuinticMotion

GROUP, TIP = 'manipulator', 'tool0'
START = (0.3, -0.9, 1.2, 0.2, 0.9, 0.1)


def test_profile_keeps_its_limits_and_arrives() -> None:
    """The rounded trapezoid goes from 0 to 1 within speed and acceleration."""
    profile = TrapezoidalProfile(0.5, 1.0, 2.0)
    times = np.linspace(0.0, profile.duration, 500)
    place, speed, rate = profile.sample(times)
    assert (place[0], place[-1]) == pytest.approx((0.0, 1.0), abs=1e-9)
    assert speed.max() == pytest.approx(0.5)
    assert (rate.max(), rate.min()) == pytest.approx((1.0, -2.0))
    assert np.gradient(place, times)[1:-1] == pytest.approx(speed[1:-1], abs=1e-3)


def test_ptp_starts_and_stops_all_joints_together(bench: Any) -> None:
    """PLZ-5: every joint is at the same share of its way at every time."""
    goal = np.array(START) * 0.5
    answer = bench.run('PTP', bench.joints(goal))
    assert answer.success, answer.message
    share = (answer.trajectory.positions - START) / (goal - START)
    assert np.ptp(share, axis=1).max() < 1e-9
    assert share[-1] == pytest.approx(np.ones(6))


def test_ptp_keeps_the_scaled_limits(bench: Any) -> None:
    """PLZ-5: speed and acceleration of every joint stay below limit times scaling."""
    answer = bench.run('PTP', bench.joints(np.array(START) * 0.5))
    speed, acceleration = QuinticMotion.of(answer.trajectory).peaks()
    model = bench.model
    index = model.group_indices(GROUP)
    assert (speed <= 0.1 * model.velocity_limits[index] * 1.001).all()
    assert (acceleration <= 0.1 * model.acceleration_limits[index] * 1.001).all()


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


def test_points_are_no_further_apart_than_the_sampling_time(bench: Any) -> None:
    """PLZ-9: a point at least every 0.1 s, rest at both ends."""
    answer = bench.run('LIN', bench.at(bench.moved(-0.1, 0.15, -0.05)))
    times = answer.trajectory.times
    assert np.diff(times).max() <= 0.1 + 1e-9
    assert (np.diff(times) > 0.0).all()
    assert not np.any(answer.trajectory.velocities[0])
    assert np.abs(answer.trajectory.velocities[-1]).max() < 1e-9


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


def test_circ_about_a_center(bench: Any) -> None:
    """PLZ-4: the shorter arc about the centre."""
    center, wanted = bench.moved(0.0, 0.08, 0.0), bench.moved(-0.08, 0.08, 0.0)
    answer = bench.run('CIRC', bench.at(wanted), path_constraints=bench.at(center, name='center'))
    assert answer.success, answer.message
    tips = bench.tips(answer.trajectory)
    assert np.linalg.norm(tips - center[:3, 3], axis=1) == pytest.approx(0.08, abs=1e-3)


@pytest.mark.parametrize(('case', 'code'), [
    ('colinear', 'INVALID_MOTION_PLAN'), ('radii', 'INVALID_MOTION_PLAN'),
    ('zero radius', 'INVALID_MOTION_PLAN'), ('name', 'INVALID_MOTION_PLAN'),
    ('count', 'INVALID_GOAL_CONSTRAINTS'), ('link', 'INVALID_LINK_NAME'),
])
def test_circ_refuses_what_is_no_circle(bench: Any, case: str, code: str) -> None:
    """PLZ-4: each mistake has its code."""
    wanted = bench.moved(0.0, 0.1, 0.0)
    helpers = {
        'colinear': bench.at(bench.moved(0.0, 0.05, 0.0), name='interim'),
        'radii': bench.at(bench.moved(0.1, 0.02, 0.0), name='center'),
        'zero radius': bench.at(bench.pose, name='center'),
        'name': bench.at(bench.moved(0.05, 0.05, 0.0), name='elsewhere'),
        'count': Constraints(name='interim'),
        'link': bench.at(bench.moved(0.05, 0.05, 0.0), link='nowhere', name='interim'),
    }
    answer = bench.run('CIRC', bench.at(wanted), path_constraints=helpers[case])
    assert answer.error_code == MoveItErrorCode[code]
    assert answer.message
    assert not len(answer.trajectory)


@pytest.mark.parametrize(('options', 'code'), [
    ({'max_velocity_scaling_factor': 0.0}, 'INVALID_MOTION_PLAN'),
    ({'max_acceleration_scaling_factor': 1.5}, 'INVALID_MOTION_PLAN'),
    ({'planner_id': 'SPLINE'}, 'PLANNING_FAILED'),
    ({'goal_constraints': ()}, 'INVALID_GOAL_CONSTRAINTS'),
    ({'group_name': 'nobody'}, 'INVALID_GROUP_NAME'),
    ({'start_state': StartState(('shoulder_pan_joint',), (0.1,), velocities=(0.3,))},
     'INVALID_ROBOT_STATE'),
])
def test_preconditions_have_codes(bench: Any, options: dict[str, Any], code: str) -> None:
    """PLZ-1, PLZ-2: what is wrong with a request is told by code and sentence."""
    fields = {
        'group_name': GROUP, 'goal_constraints': (bench.at(bench.moved(0.0, 0.05, 0.0)),),
        'pipeline_id': 'pilz_industrial_motion_planner', 'planner_id': 'LIN', **options,
    }
    answer = bench.planner.plan(
        MotionPlanRequest(**fields), bench.scene.snapshot(), clock=time.monotonic
    )
    assert answer.error_code == MoveItErrorCode[code]
    assert answer.message


def test_goals_that_are_no_single_goal_are_refused(bench: Any) -> None:
    """PLZ-2: mixed goals, foreign joints, two links and values beyond limits are -16."""
    pose = bench.at(bench.moved(0.0, 0.05, 0.0))
    mixed = Constraints(bench.joints(START).joint_constraints, pose.position_constraints,
                        pose.orientation_constraints)
    other = bench.at(bench.moved(0.0, 0.05, 0.0), link='wrist_1_link').orientation_constraints
    two_links = Constraints(position_constraints=pose.position_constraints,
                            orientation_constraints=other)
    for goal in (
        mixed, two_links, Constraints(joint_constraints=(JointConstraint('nobody', 0.0),)),
        bench.joints([50.0]), Constraints(position_constraints=pose.position_constraints),
    ):
        assert bench.run('LIN', goal).error_code == MoveItErrorCode.INVALID_GOAL_CONSTRAINTS


def test_unreachable_goal(bench: Any) -> None:
    """PLZ-3: a pose out of reach is -31."""
    assert bench.run('LIN', bench.at(bench.moved(5.0, 0.0, 0.0))).error_code == (
        MoveItErrorCode.NO_IK_SOLUTION
    )


def test_too_fast_for_a_joint(bench: Any) -> None:
    """PLZ-3: a joint limit that the line would break is 99999 and names the joint."""
    answer = bench.run('LIN', bench.at(bench.moved(-0.1, 0.3, -0.1)),
                       max_velocity_scaling_factor=1.0, max_acceleration_scaling_factor=1.0)
    assert answer.error_code == MoveItErrorCode.FAILURE
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


def test_max_cartesian_speed_slows_a_command(bench: Any) -> None:
    """REQ-12: the tip is no faster than max_cartesian_speed."""
    answer = bench.run('PTP', bench.at(bench.moved(-0.1, 0.3, 0.1)), max_cartesian_speed=0.02)
    tips = bench.tips(answer.trajectory)
    step = answer.trajectory.duration / (len(tips) - 1)
    assert (np.linalg.norm(np.diff(tips, axis=0), axis=1) / step).max() < 0.0205
