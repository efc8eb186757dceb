# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Point-to-point, linear and circular commands."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Box, Sphere
from armsim_ros.model.loading import load_robot_model
from armsim_ros.model.transforms import pose_from_parts, quat_xyzw_from_matrix
from armsim_ros.planning.error_codes import MoveItErrorCode
from armsim_ros.planning.pilz.profile import TrapezoidalProfile
from armsim_ros.planning.planner import MotionPlanner
from armsim_ros.planning.quintic import QuinticMotion
from armsim_ros.planning.request import (
    Constraints,
    JointConstraint,
    MotionPlanRequest,
    OrientationConstraint,
    PositionConstraint,
    Region,
    StartState,
)
from armsim_ros.planning.scene import PlanningScene
from armsim_ros.planning.scene_update import CollisionObjectUpdate

GROUP, TIP = 'manipulator', 'tool0'
START = (0.3, -0.9, 1.2, 0.2, 0.9, 0.1)


class Bench:
    """A UR5 at a start state and requests for it."""

    def __init__(self) -> None:
        robot = load_robot_model(load_robot_settings('ur5'))
        self.model = KinematicModel(robot)
        self.scene = PlanningScene(self.model)
        self.planner = MotionPlanner(self.scene)
        self.names = robot.semantic.groups[GROUP].active_joints
        self.q = self.model.insert(self.model.default(), GROUP, START)
        self.scene.set_state(self.q)
        self.pose = self.model.link_pose(self.q, TIP)

    def moved(self, *offset: float) -> Any:
        """Return the tip's pose, moved [m]."""
        return pose_from_parts(self.pose[:3, 3] + np.array(offset), self.pose[:3, :3])

    def run(self, command: str, goal: Constraints, **options: Any) -> Any:
        speed = {'max_velocity_scaling_factor': 0.1, 'max_acceleration_scaling_factor': 0.1}
        request = MotionPlanRequest(
            GROUP, (goal,), pipeline_id='pilz_industrial_motion_planner', planner_id=command,
            **{**speed, **options},
        )
        return self.planner.plan(request, self.scene.snapshot(), clock=time.monotonic)

    def tips(self, trajectory: Any) -> Any:
        """Return where the tip is along a trajectory, between its points too (k, 3)."""
        motion = motion_of(trajectory)
        return np.array([
            self.model.link_pose(self.model.insert(self.q, GROUP, values), TIP)[:3, 3]
            for values in motion.sample(np.linspace(0.0, motion.duration, 300))
        ])


def motion_of(trajectory: Any) -> QuinticMotion:
    """Return a trajectory as a controller runs it."""
    points = trajectory.points
    return QuinticMotion(
        trajectory.times(), trajectory.positions(),
        np.array([point.velocities for point in points]),
        np.array([point.accelerations for point in points]),
    )


def joints(bench: Bench, values: Any) -> Constraints:
    """Return a goal of joint positions [rad]."""
    return Constraints(joint_constraints=tuple(
        JointConstraint(name, float(value), 1e-3, 1e-3)
        for name, value in zip(bench.names, values, strict=False)
    ))


def at(pose: Any, link: str = TIP, name: str = '') -> Constraints:
    """Return a goal pose (4, 4), or with a name the point of an arc."""
    region = Region(Sphere(1e-3), pose_from_parts(pose[:3, 3], np.eye(3)))
    return Constraints(
        position_constraints=(PositionConstraint(link, (region,), 'base_link'),),
        orientation_constraints=() if name else (OrientationConstraint(
            link, tuple(quat_xyzw_from_matrix(pose)), (1e-3,) * 3, 'base_link'
        ),),
        name=name,
    )


@pytest.fixture(scope='module')
def built() -> Bench:
    """Build the robot once."""
    return Bench()


@pytest.fixture
def bench(built: Bench) -> Bench:
    """Give the robot at its start in an empty world."""
    built.scene.clear()
    built.scene.set_state(built.q)
    return built


def test_profile_keeps_its_limits_and_arrives() -> None:
    """The rounded trapezoid goes from 0 to 1 within speed and acceleration."""
    profile = TrapezoidalProfile(0.5, 1.0, 2.0)
    times = np.linspace(0.0, profile.duration, 500)
    place, speed, rate = profile.sample(times)
    assert (place[0], place[-1]) == pytest.approx((0.0, 1.0), abs=1e-9)
    assert speed.max() == pytest.approx(0.5)
    assert (rate.max(), rate.min()) == pytest.approx((1.0, -2.0))
    assert np.gradient(place, times)[1:-1] == pytest.approx(speed[1:-1], abs=1e-3)


def test_ptp_starts_and_stops_all_joints_together(bench: Bench) -> None:
    """PLZ-5: every joint is at the same share of its way at every time."""
    goal = np.array(START) * 0.5
    answer = bench.run('PTP', joints(bench, goal))
    assert answer.success, answer.message
    share = (answer.trajectory.positions() - START) / (goal - START)
    assert np.ptp(share, axis=1).max() < 1e-9
    assert share[-1] == pytest.approx(np.ones(6))


def test_ptp_keeps_the_scaled_limits(bench: Bench) -> None:
    """PLZ-5: speed and acceleration of every joint stay below limit times scaling."""
    answer = bench.run('PTP', joints(bench, np.array(START) * 0.5))
    speed, acceleration = motion_of(answer.trajectory).peaks()
    model = bench.model
    index = model.group_indices(GROUP)
    assert (speed <= 0.1 * model.velocity_limits[index] * 1.001).all()
    assert (acceleration <= 0.1 * model.acceleration_limits[index] * 1.001).all()


def test_ptp_reaches_a_pose(bench: Bench) -> None:
    """A pose goal is brought to joint positions first."""
    wanted = bench.moved(0.1, 0.1, -0.1)
    answer = bench.run('PTP', at(wanted))
    assert answer.success, answer.message
    assert bench.tips(answer.trajectory)[-1] == pytest.approx(wanted[:3, 3], abs=1e-4)


def test_lin_is_straight(bench: Bench) -> None:
    """PLZ-3: the link stays within 1 mm of the line, between the points too."""
    wanted = bench.moved(-0.1, 0.15, -0.05)
    answer = bench.run('LIN', at(wanted))
    assert answer.success, answer.message
    way = wanted[:3, 3] - bench.pose[:3, 3]
    way /= np.linalg.norm(way)
    off = bench.tips(answer.trajectory) - bench.pose[:3, 3]
    assert np.abs(off - np.outer(off @ way, way)).max() < 1e-3
    assert off[-1] == pytest.approx(wanted[:3, 3] - bench.pose[:3, 3], abs=1e-4)


def test_points_are_no_further_apart_than_the_sampling_time(bench: Bench) -> None:
    """PLZ-9: a point at least every 0.1 s, rest at both ends."""
    answer = bench.run('LIN', at(bench.moved(-0.1, 0.15, -0.05)))
    times = answer.trajectory.times()
    assert np.diff(times).max() <= 0.1 + 1e-9
    assert (np.diff(times) > 0.0).all()
    assert not np.any(answer.trajectory.points[0].velocities)
    assert np.abs(answer.trajectory.points[-1].velocities).max() < 1e-9


def test_circ_through_an_interim_point(bench: Bench) -> None:
    """PLZ-4: the link goes through the interim point on a circle."""
    interim, wanted = bench.moved(-0.05, 0.05, 0.0), bench.moved(0.0, 0.1, 0.0)
    answer = bench.run('CIRC', at(wanted), path_constraints=at(interim, name='interim'))
    assert answer.success, answer.message
    center = bench.pose[:3, 3] + [0.0, 0.05, 0.0]
    tips = bench.tips(answer.trajectory)
    assert np.linalg.norm(tips - center, axis=1) == pytest.approx(0.05, abs=1e-3)
    assert np.linalg.norm(tips - interim[:3, 3], axis=1).min() < 2e-3


def test_circ_about_a_center(bench: Bench) -> None:
    """PLZ-4: the shorter arc about the centre."""
    center, wanted = bench.moved(0.0, 0.08, 0.0), bench.moved(-0.08, 0.08, 0.0)
    answer = bench.run('CIRC', at(wanted), path_constraints=at(center, name='center'))
    assert answer.success, answer.message
    tips = bench.tips(answer.trajectory)
    assert np.linalg.norm(tips - center[:3, 3], axis=1) == pytest.approx(0.08, abs=1e-3)


@pytest.mark.parametrize(('case', 'code'), [
    ('colinear', 'INVALID_MOTION_PLAN'), ('radii', 'INVALID_MOTION_PLAN'),
    ('zero radius', 'INVALID_MOTION_PLAN'), ('name', 'INVALID_MOTION_PLAN'),
    ('count', 'INVALID_GOAL_CONSTRAINTS'), ('link', 'INVALID_LINK_NAME'),
])
def test_circ_refuses_what_is_no_circle(bench: Bench, case: str, code: str) -> None:
    """PLZ-4: each mistake has its code."""
    wanted = bench.moved(0.0, 0.1, 0.0)
    helpers = {
        'colinear': at(bench.moved(0.0, 0.05, 0.0), name='interim'),
        'radii': at(bench.moved(0.1, 0.02, 0.0), name='center'),
        'zero radius': at(bench.pose, name='center'),
        'name': at(bench.moved(0.05, 0.05, 0.0), name='elsewhere'),
        'count': Constraints(name='interim'),
        'link': at(bench.moved(0.05, 0.05, 0.0), link='nowhere', name='interim'),
    }
    answer = bench.run('CIRC', at(wanted), path_constraints=helpers[case])
    assert answer.error_code == MoveItErrorCode[code]
    assert answer.message
    assert not answer.trajectory.points


@pytest.mark.parametrize(('options', 'code'), [
    ({'max_velocity_scaling_factor': 0.0}, 'INVALID_MOTION_PLAN'),
    ({'max_acceleration_scaling_factor': 1.5}, 'INVALID_MOTION_PLAN'),
    ({'planner_id': 'SPLINE'}, 'PLANNING_FAILED'),
    ({'goal_constraints': ()}, 'INVALID_GOAL_CONSTRAINTS'),
    ({'group_name': 'nobody'}, 'INVALID_GROUP_NAME'),
    ({'start_state': StartState(('shoulder_pan_joint',), (0.1,), velocities=(0.3,))},
     'INVALID_ROBOT_STATE'),
])
def test_preconditions_have_codes(bench: Bench, options: dict[str, Any], code: str) -> None:
    """PLZ-1, PLZ-2: what is wrong with a request is told by code and sentence."""
    fields = {
        'group_name': GROUP, 'goal_constraints': (at(bench.moved(0.0, 0.05, 0.0)),),
        'pipeline_id': 'pilz_industrial_motion_planner', 'planner_id': 'LIN', **options,
    }
    answer = bench.planner.plan(
        MotionPlanRequest(**fields), bench.scene.snapshot(), clock=time.monotonic
    )
    assert answer.error_code == MoveItErrorCode[code]
    assert answer.message


def test_goals_that_are_no_single_goal_are_refused(bench: Bench) -> None:
    """PLZ-2: mixed goals, foreign joints, two links and values beyond limits are -16."""
    pose = at(bench.moved(0.0, 0.05, 0.0))
    mixed = Constraints(joints(bench, START).joint_constraints, pose.position_constraints,
                        pose.orientation_constraints)
    other = at(bench.moved(0.0, 0.05, 0.0), link='wrist_1_link').orientation_constraints
    two_links = Constraints(position_constraints=pose.position_constraints,
                            orientation_constraints=other)
    for goal in (
        mixed, two_links, Constraints(joint_constraints=(JointConstraint('nobody', 0.0),)),
        joints(bench, [50.0]), Constraints(position_constraints=pose.position_constraints),
    ):
        assert bench.run('LIN', goal).error_code == MoveItErrorCode.INVALID_GOAL_CONSTRAINTS


def test_unreachable_goal(bench: Bench) -> None:
    """PLZ-3: a pose out of reach is -31."""
    assert bench.run('LIN', at(bench.moved(5.0, 0.0, 0.0))).error_code == (
        MoveItErrorCode.NO_IK_SOLUTION
    )


def test_too_fast_for_a_joint(bench: Bench) -> None:
    """PLZ-3: a joint limit that the line would break is 99999 and names the joint."""
    answer = bench.run('LIN', at(bench.moved(-0.1, 0.3, -0.1)), max_velocity_scaling_factor=1.0,
                       max_acceleration_scaling_factor=1.0)
    assert answer.error_code == MoveItErrorCode.FAILURE
    assert '_joint' in answer.message


def test_obstacles_are_not_avoided_but_seen(bench: Bench) -> None:
    """PLZ-6: a command whose way is blocked is -2."""
    wanted = bench.moved(-0.1, 0.3, -0.1)
    middle = 0.5 * (bench.pose + wanted)
    bench.scene.apply_object(CollisionObjectUpdate(
        'post', pose=pose_from_parts(middle[:3, 3], np.eye(3)),
        primitives=(Box((0.02, 0.02, 0.02)),), primitive_poses=(np.eye(4),),
    ))
    answer = bench.run('LIN', at(wanted))
    assert answer.error_code == MoveItErrorCode.INVALID_MOTION_PLAN
    assert "'post'" in answer.message


def test_max_cartesian_speed_slows_a_command(bench: Bench) -> None:
    """REQ-12: the tip is no faster than max_cartesian_speed."""
    answer = bench.run('PTP', at(bench.moved(-0.1, 0.3, 0.1)), max_cartesian_speed=0.02)
    tips = bench.tips(answer.trajectory)
    step = answer.trajectory.duration / (len(tips) - 1)
    assert (np.linalg.norm(np.diff(tips, axis=0), axis=1) / step).max() < 0.0205
