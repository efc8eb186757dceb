# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of requests that cannot be fulfilled, and of what they leave behind."""

from dataclasses import replace
import itertools
import math
import time

import numpy as np
import pytest
from six_axis_requests import joint_goal, LEFT, pose_goal, request, RIGHT
from small_arms import two_six_axis_arms

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.context import PlanningPipeline, PlanningSettings
from armsim_ros.planning.planner import MotionPlanner
from armsim_ros.planning.request import (
    Constraints,
    JointConstraint,
    MotionPlanRequest,
    OrientationConstraint,
)
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import StartState


@pytest.mark.parametrize(('changes', 'code', 'words'), [
    ({'group_name': 'amr'}, -15, "did you mean 'arm'"),
    ({'group_name': ''}, -15, 'known groups: arm'),
    ({'pipeline_id': 'chomp'}, 99999, 'known: ompl'),
    ({'goal_constraints': ()}, -16, 'goal_constraints is empty'),
    ({'goal_constraints': (joint_goal((0.0,), ('elbow',)),)}, -16, "'elbow'"),
    ({'start_state': StartState(('axis1', 'axis2'), (0.0,))}, -17, ''),
    ({'start_state': StartState(('axis9',), (0.0,))}, -17, 'axis9'),
    ({'start_state': StartState(('axis1',), (math.nan,))}, -17, 'axis1'),
    ({'start_state': StartState(('axis1',), (3.2,))}, -26, "'axis1' starts at 3.20000"),
    ({'has_trajectory_constraints': True, 'pipeline_id': 'pilz_industrial_motion_planner'}, -1,
     'trajectory_constraints'),
    ({'max_cartesian_speed': 0.1, 'cartesian_speed_limited_link': 'tol'}, -18, "'tol'"),
])
def test_wrong_requests(six_scene, plan_for, clock, log, changes, code, words):
    """E1, E2, E3, E6, E13: each mistake has its code and a sentence, and is logged."""
    response = plan_for(six_scene).plan(
        replace(request(joint_goal(RIGHT)), **changes), six_scene, clock=clock)
    assert response.error_code == code
    assert words in response.message
    assert response.source
    assert not len(response.trajectory)
    assert response.message in log.recorder.text()


def test_only_the_groups_joints_have_to_start_within_their_limits(log):
    """
    A joint that the planning group does not move may start beyond its limits.

    Upstream: check_start_state_bounds.cpp.
    """
    scene = PlanningScene(KinematicModel(two_six_axis_arms()))
    scene.set_positions({'right_axis1': 3.2, 'right_axis2': 1.0})
    planner = MotionPlanner(scene, log=log)
    for side, code in (('left', 1), ('right', -26), ('both', -26)):
        wanted = MotionPlanRequest(
            side, (Constraints.of_joints({f'{side.replace("both", "left")}_axis1': 0.2}),), seed=1)
        assert planner.plan(wanted, scene, clock=time.monotonic).error_code == code


@pytest.mark.parametrize(('adapters', 'warned'), [
    (('CheckForStackedConstraints',), True), ((), False)])
def test_stacked_constraints_are_warned_about(
        six_scene, plan_for, clock, log, adapters, warned):
    """
    Several orientations in a goal are a warning where the adapter is listed.

    Upstream: check_for_stacked_constraints.cpp.
    """
    kept = Constraints(orientation_constraints=(
        OrientationConstraint('tool', (0.0, 0.0, 0.0, 1.0), (4.0,) * 3, 'base'),) * 2)
    goal = replace(joint_goal(RIGHT), orientation_constraints=kept.orientation_constraints)
    settings = PlanningSettings(
        {'ompl': PlanningPipeline(request_adapters=frozenset(adapters))})
    assert plan_for(six_scene, settings).plan(request(goal), six_scene, clock=clock).success
    assert ('goal constraints have more than one' in log.recorder.text()) is warned


def test_trajectory_constraints_are_ignored(six_scene, plan_for, clock, log):
    """
    OMPL's pipeline plans without trajectory constraints, with a warning.

    Upstream: planning_context_manager.cpp, getPlanningContext.
    """
    wanted = request(joint_goal(RIGHT), has_trajectory_constraints=True)
    assert plan_for(six_scene).plan(wanted, six_scene, clock=clock).success
    assert 'planning without them' in log.recorder.text()


def test_start_in_collision(wall, add_box, plan_for, clock):
    """ADP-4: a colliding start is refused with -10 and the pair."""
    add_box(wall, 'crate', (0.3, 0.3, 0.3), (0.45, -0.55, 0.4))
    response = plan_for(wall).plan(request(joint_goal(RIGHT)), wall, clock=clock)
    assert response.error_code == -10
    assert "'crate'" in response.message


def test_goal_in_collision(wall, add_box, plan_for, clock):
    """E8: a goal whose states all collide is refused with -12 and the pair."""
    add_box(wall, 'crate', (0.3, 0.3, 0.3), (0.45, 0.55, 0.4))
    response = plan_for(wall).plan(request(joint_goal(RIGHT)), wall, clock=clock)
    assert response.error_code == -12
    assert "'crate'" in response.message


def test_pose_out_of_reach(six_scene, plan_for, clock):
    """E7: a pose that cannot be reached is refused with -31, naming link and place."""
    response = plan_for(six_scene).plan(
        request(pose_goal(pose_matrix((2.0, 0.0, 0.5)))), six_scene, clock=clock)
    assert response.error_code == -31
    assert "'tool' at [2.0, 0.0, 0.5]" in response.message


def test_no_way(six_scene, add_box, plan_for, clock):
    """E9: where no path exists the search ends at the allowed time with -6."""
    add_box(six_scene, 'fence', (0.02, 3.0, 3.0), (0.0, 0.0, 1.9), (0.0, 0.0, math.pi / 2))
    add_box(six_scene, 'front', (3.0, 0.02, 3.0), (0.0, 0.0, 1.9), (0.0, 0.0, math.pi / 2))
    start = (-0.8, 1.4, 0.2, 0.0, 0.5, 0.0)
    narrow = replace(
        request(joint_goal((0.8, 1.4, 0.2, 0.0, 0.5, 0.0)), start, allowed_planning_time=0.3),
        path_constraints=Constraints((JointConstraint('axis2', 1.4, 0.02, 0.02),)))
    add_box(six_scene, 'post', (0.02, 0.02, 1.0), (0.45, 0.0, 0.4))
    add_box(six_scene, 'plate', (0.5, 0.02, 1.0), (0.4, 0.0, 0.4))
    response = plan_for(six_scene).plan(narrow, six_scene, clock=clock)
    assert response.error_code == -6
    assert 'allowed_planning_time' in response.message


def test_cancel(wall, plan_for, clock):
    """E18: a cancelled request ends with -7."""
    asked = itertools.count()
    response = plan_for(wall).plan(
        request(joint_goal(RIGHT)), wall, clock=clock, cancelled=lambda: next(asked) > 20)
    assert response.error_code == -7
    assert not len(response.trajectory)


def test_the_next_request_works_after_a_failure(wall, plan_for, clock):
    """ERR-2: failures leave nothing behind."""
    planner = plan_for(wall)
    planner.plan(request(joint_goal(RIGHT)), wall, clock=clock, cancelled=lambda: True)
    planner.plan(request(joint_goal((9.0,), ('elbow',))), wall, clock=clock)
    assert planner.plan(request(joint_goal(RIGHT)), wall, clock=clock).success


def test_the_scene_is_not_changed(wall, plan_for, clock):
    """REQ-7: a start state of a request is for that request only."""
    before = wall.content
    plan_for(wall).plan(request(joint_goal(RIGHT)), wall, clock=clock)
    assert wall.content is before


def test_start_a_little_beyond_a_limit(six_scene, plan_for, clock, log):
    """SEED-10: ``start_state_max_bounds_error`` lets a start be moved back to the limit."""
    settings = PlanningSettings({'ompl': PlanningPipeline(start_state_max_bounds_error=0.05)})
    response = plan_for(six_scene, settings).plan(
        request(joint_goal(RIGHT), (2.93, *LEFT[1:])), six_scene, clock=clock)
    assert response.success
    assert response.trajectory.positions[0, 0] == pytest.approx(2.9)
    assert 'beyond its limit' in log.recorder.text()


def test_missing_acceleration_limits_are_assumed(six, plan_for, clock, log):
    """BOOT-5: without acceleration limits 1 rad/s^2 is assumed, with one warning a joint."""
    robot = six.robot
    joints = {
        name: replace(joint, limits=replace(joint.limits, acceleration=math.inf))
        for name, joint in robot.joints.items()}
    scene = PlanningScene(KinematicModel(replace(robot, joints=joints)))
    planner = plan_for(scene)
    for _ in range(2):
        response = planner.plan(request(joint_goal(RIGHT)), scene, clock=clock)
    accelerations = np.abs(response.trajectory.accelerations)
    assert accelerations.max() == pytest.approx(1.0, rel=0.01)
    assert log.recorder.text().count('joints have no acceleration limit: axis1, axis2') == 1


def test_a_continuous_joint_may_start_any_number_of_turns_away(turning, plan_for, clock):
    """A continuous joint is planned from where it is, by the short way to its goal."""
    scene = PlanningScene(KinematicModel(turning))
    names = ('axis1', 'axis2', 'axis3')
    answer = plan_for(scene).plan(MotionPlanRequest(
        'arm', (joint_goal((0.1, 0.5, 0.0), names),), StartState(names, (100.0, 0.5, 0.0)),
        seed=1), scene, clock=clock)
    assert answer.success, answer.message
    assert answer.trajectory.positions[0, 0] == pytest.approx(100.0)
    assert abs(answer.trajectory.positions[-1, 0] - 100.0) < math.pi
