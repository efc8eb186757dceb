# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What requests for PTP, LIN and CIRC have to be, and the codes of those that are not."""

from __future__ import annotations

from dataclasses import replace
import time
from typing import Any

import numpy as np
import pytest

from armsim_ros.errors import MoveItErrorCode
from armsim_ros.model.transforms import pose_from_parts
from armsim_ros.planning.context import PlanningSettings
from armsim_ros.planning.planner import MotionPlanner
from armsim_ros.planning.request import Constraints, JointConstraint, MotionPlanRequest
from armsim_ros.planning.scene.update import StartState

GROUP, TIP = 'manipulator', 'tool0'
START = (0.3, -0.9, 1.2, 0.2, 0.9, 0.1)


@pytest.mark.parametrize(('case', 'code'), [
    ('colinear', 'INVALID_MOTION_PLAN'), ('radii', 'INVALID_MOTION_PLAN'),
    ('zero radius', 'INVALID_MOTION_PLAN'), ('name', 'INVALID_MOTION_PLAN'),
    ('count', 'INVALID_MOTION_PLAN'), ('poses', 'INVALID_MOTION_PLAN'),
    ('two poses', 'INVALID_MOTION_PLAN'), ('half circle', 'INVALID_MOTION_PLAN'),
])
def test_circ_refuses_what_is_no_circle(bench: Any, case: str, code: str) -> None:
    """
    An arc takes a name, one position constraint with one pose, and points that give a circle.

    pilz, trajectory_generator_circ.cpp, cmdSpecificRequestValidation and setPathCIRC.
    """
    wanted = bench.moved(0.0, 0.1, 0.0)
    good = bench.at(bench.moved(0.05, 0.05, 0.0), name='interim')
    region, = good.position_constraints[0].regions
    helpers = {
        'colinear': bench.at(bench.moved(0.0, 0.05, 0.0), name='interim'),
        'radii': bench.at(bench.moved(0.1, 0.02, 0.0), name='center'),
        'zero radius': bench.at(bench.pose, name='center'),
        'name': replace(good, name='elsewhere'),
        'count': Constraints(name='interim'),
        'poses': replace(good, position_constraints=(
            replace(good.position_constraints[0], regions=()),)),
        'two poses': replace(good, position_constraints=(
            replace(good.position_constraints[0], regions=(region, region)),)),
        'half circle': bench.at(bench.moved(0.0, 0.05, 0.0), name='center'),
    }
    answer = bench.run('CIRC', bench.at(wanted), path_constraints=helpers[case])
    assert answer.error_code == MoveItErrorCode[code]
    assert answer.message
    assert not len(answer.trajectory)
    assert bench.run('CIRC', bench.at(wanted), path_constraints=good).success


@pytest.mark.parametrize(('options', 'code'), [
    ({'max_velocity_scaling_factor': 0.0}, 'INVALID_MOTION_PLAN'),
    ({'max_velocity_scaling_factor': 0.0001}, 'INVALID_MOTION_PLAN'),
    ({'max_velocity_scaling_factor': 1.1}, 'INVALID_MOTION_PLAN'),
    ({'max_acceleration_scaling_factor': 0.0}, 'INVALID_MOTION_PLAN'),
    ({'max_acceleration_scaling_factor': 1.5}, 'INVALID_MOTION_PLAN'),
    ({'planner_id': 'SPLINE'}, 'PLANNING_FAILED'),
    ({'planner_id': ''}, 'PLANNING_FAILED'),
    ({'group_name': 'nobody'}, 'PLANNING_FAILED'),
    ({'group_name': ''}, 'PLANNING_FAILED'),
    ({'has_trajectory_constraints': True}, 'PLANNING_FAILED'),
    ({'goal_constraints': ()}, 'INVALID_GOAL_CONSTRAINTS'),
    ({'start_state': StartState(('shoulder_pan_joint',), (0.1,), velocities=(0.3,))},
     'INVALID_ROBOT_STATE'),
    ({'start_state': StartState(('shoulder_pan_joint',), (7.0,))}, 'START_STATE_INVALID'),
    ({'start_state': StartState(('shoulder_pan_joint',), (0.3,), velocities=(1e-9,))},
     'SUCCESS'),
])
def test_preconditions_have_codes(bench: Any, options: dict[str, Any], code: str) -> None:
    """
    A request without a command or a group has no planning context; others break a rule.

    pilz, pilz_industrial_motion_planner.cpp, canServiceRequest; trajectory_generator.cpp,
    validateRequest.
    """
    fields = {
        'group_name': GROUP, 'goal_constraints': (bench.at(bench.moved(0.0, 0.05, 0.0)),),
        'max_velocity_scaling_factor': 0.1, 'max_acceleration_scaling_factor': 0.1,
        'pipeline_id': 'pilz_industrial_motion_planner', 'planner_id': 'LIN', **options,
    }
    answer = bench.planner.plan(
        MotionPlanRequest(**fields), bench.scene.snapshot(), clock=time.monotonic
    )
    assert answer.error_code == MoveItErrorCode[code]
    assert bool(answer.message) != answer.success


def test_group_without_solver(bench: Any) -> None:
    """
    A group without kinematics solver has no planning context, for joint goals too.

    pilz, pilz_industrial_motion_planner.cpp, canServiceRequest.
    """
    planner = MotionPlanner(
        bench.scene, settings=PlanningSettings(solver_groups=frozenset({'other'})))
    answer = planner.plan(bench.request('PTP', bench.joints(START)), bench.scene.snapshot(),
                          clock=time.monotonic)
    assert answer.error_code == MoveItErrorCode.PLANNING_FAILED
    assert 'has no kinematics solver' in answer.message


def test_goals_that_are_no_single_goal_are_refused(bench: Any) -> None:
    """
    Two goals, mixed goals, joints of other groups, two links and values beyond limits are -16.

    pilz, trajectory_generator.cpp, checkGoalConstraints.
    """
    pose = bench.at(bench.moved(0.0, 0.05, 0.0))
    mixed = Constraints(bench.joints(START).joint_constraints, pose.position_constraints,
                        pose.orientation_constraints)
    other = bench.at(bench.moved(0.0, 0.05, 0.0), link='wrist_1_link').orientation_constraints
    two_links = Constraints(position_constraints=pose.position_constraints,
                            orientation_constraints=other)
    nameless = bench.at(bench.moved(0.0, 0.05, 0.0), link='')
    no_pose = replace(pose, position_constraints=(
        replace(pose.position_constraints[0], regions=()),))
    for goal in (
        mixed, two_links, nameless, no_pose, Constraints(),
        Constraints(joint_constraints=(JointConstraint('nobody', 0.0),)),
        bench.joints([50.0]), Constraints(position_constraints=pose.position_constraints),
    ):
        assert bench.run('LIN', goal).error_code == MoveItErrorCode.INVALID_GOAL_CONSTRAINTS
    twice = bench.request('LIN', pose, goal_constraints=(pose, pose))
    answer = bench.planner.plan(twice, bench.scene.snapshot(), clock=time.monotonic)
    assert answer.error_code == MoveItErrorCode.INVALID_GOAL_CONSTRAINTS


@pytest.mark.parametrize('link', ['nowhere', 'forearm_link'])
def test_links_that_the_solver_does_not_position(bench: Any, link: str) -> None:
    """
    A goal for a link that is not fixed to the tip of the solver is -31.

    pilz, trajectory_generator.cpp, checkCartesianGoalConstraint.
    """
    answer = bench.run('PTP', bench.at(bench.moved(0.0, 0.05, 0.0), link=link))
    assert answer.error_code == MoveItErrorCode.NO_IK_SOLUTION


def test_frame_of_the_position_holds_for_the_orientation(bench: Any) -> None:
    """
    The orientation's own frame counts only by being named; without both it is the model frame.

    pilz, trajectory_generator_lin.cpp, extractMotionPlanInfo.
    """
    wanted = bench.moved(-0.1, 0.1, 0.0)
    plain = bench.run('LIN', bench.at(wanted)).trajectory.positions[-1]
    frame = bench.scene.frame_pose('shoulder_link')
    local = np.linalg.inv(frame) @ wanted
    goal = bench.at(local)
    position, orientation = goal.position_constraints[0], goal.orientation_constraints[0]
    position = replace(position, frame_id='shoulder_link')
    for given, expected in (('wrist_1_link', True), ('', False)):
        goal = Constraints(position_constraints=(position,),
                           orientation_constraints=(replace(orientation, frame_id=given),))
        answer = bench.run('LIN', goal)
        same = answer.success and np.allclose(
            answer.trajectory.positions[-1], plain, atol=1e-4)
        assert same == expected


def test_frames_are_where_they_are_now(bench: Any) -> None:
    """
    A link as frame means its pose in the monitored state, not in the request's start state.

    pilz, trajectory_generator.cpp, generate: the request's scene finds frames.
    """
    q = bench.model.insert(bench.q, GROUP, np.array(START) + 0.1)
    wanted = bench.moved(-0.1, 0.1, 0.0)
    local = np.linalg.inv(bench.scene.frame_pose('wrist_3_link')) @ wanted
    goal = bench.at(local)
    goal = Constraints(
        position_constraints=(replace(goal.position_constraints[0], frame_id='wrist_3_link'),),
        orientation_constraints=goal.orientation_constraints)
    answer = bench.run('LIN', goal, start_state=StartState.from_positions(
        bench.model.positions(q)))
    assert answer.success, answer.message
    assert bench.tips(answer.trajectory)[-1] == pytest.approx(wanted[:3, 3], abs=1e-4)


def test_quaternions_are_normalized(bench: Any) -> None:
    """
    A goal orientation may have any length but 0.

    pilz, trajectory_functions.cpp, getConstraintPose.
    """
    goal = bench.at(bench.moved(-0.05, 0.1, 0.0))
    orientation, = goal.orientation_constraints
    for factor, success in ((3.0, True), (0.0, False)):
        quat = tuple(factor * value for value in orientation.quat_xyzw)
        scaled = replace(goal, orientation_constraints=(replace(orientation, quat_xyzw=quat),))
        assert bench.run('LIN', scaled).success == success


def test_poses_without_shapes_are_enough(bench: Any) -> None:
    """
    Goals and auxiliary points need primitive poses, but no primitives.

    pilz, trajectory_generator_circ.cpp, cmdSpecificRequestValidation.
    """
    def bare(constraints: Constraints) -> Constraints:
        position, = constraints.position_constraints
        return replace(constraints, position_constraints=(replace(
            position, regions=(), primitive_poses=position.poses),))

    goal, center = bench.moved(-0.08, 0.08, 0.0), bench.moved(0.0, 0.08, 0.0)
    answer = bench.run('CIRC', bare(bench.at(goal)),
                       path_constraints=bare(bench.at(center, name='center')))
    assert answer.success, answer.message


def test_path_constraints_hold_at_the_start_too(bench: Any) -> None:
    """
    The path constraints are verified on the path, its start among it: -2.

    moveit_ros, validate_path.cpp, adapt.
    """
    keep = Constraints((JointConstraint(bench.names[0], START[0] + 0.5, 0.1, 0.1),))
    answer = bench.run('LIN', bench.at(bench.moved(0.0, 0.05, 0.0)), path_constraints=keep)
    assert answer.error_code == MoveItErrorCode.INVALID_MOTION_PLAN


def test_endless_arcs_end_where_the_arm_cannot_follow(bench: Any) -> None:
    """
    An interim point at the end of the world is refused as soon as the arc leaves the reach.

    pilz, trajectory_functions.cpp, generateJointTrajectory.
    """
    far = bench.at(bench.moved(1e5, 0.02, 0.0), name='interim')
    answer = bench.run('CIRC', bench.at(bench.moved(0.0, 0.1, 0.0)), path_constraints=far,
                       max_velocity_scaling_factor=0.05)
    assert answer.error_code in (
        MoveItErrorCode.NO_IK_SOLUTION, MoveItErrorCode.PLANNING_FAILED)


def test_pose_of_an_offset_point(bench: Any) -> None:
    """
    target_point_offset is given in the link's axes at the goal.

    pilz, trajectory_functions.cpp, getConstraintPose.
    """
    offset = (0.0, 0.02, 0.05)
    wanted = bench.moved(-0.05, 0.1, 0.0)
    point = pose_from_parts(wanted[:3, 3] + wanted[:3, :3] @ offset, wanted[:3, :3])
    goal = bench.at(point)
    goal = replace(goal, position_constraints=(
        replace(goal.position_constraints[0], target_point_offset=offset),))
    answer = bench.run('PTP', goal)
    assert bench.tips(answer.trajectory)[-1] == pytest.approx(wanted[:3, 3], abs=1e-4)
