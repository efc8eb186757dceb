# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of planning from a request to a checked trajectory."""

import math

import numpy as np
import pytest
from six_axis_requests import joint_goal, LEFT, request, RIGHT, SIX, WALL
from trajectory_judge import between, judge, poses

from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.context import PlanningPipeline, PlanningSettings
from armsim_ros.planning.request import Constraints
from armsim_ros.planning.scene.update import SceneUpdate
from armsim_ros.planning.search.planners import PlannerTable


def test_free_motion_is_the_straight_line(six_scene, plan_for, clock):
    """Where nothing is in the way the arm goes straight in joint space."""
    response = plan_for(six_scene).plan(request(joint_goal(RIGHT)), six_scene, clock=clock)
    assert response.success, response.message
    assert response.path_length == pytest.approx(1.8)
    positions = response.trajectory.positions
    assert np.ptp(positions[:, 1:], axis=0).max() < 1e-9


def test_response_of_a_plan(six_scene, plan_for, clock):
    """REQ-17: joints of the group, start first at time 0, times increasing, rest at both ends."""
    response = plan_for(six_scene).plan(request(joint_goal(RIGHT)), six_scene, clock=clock)
    trajectory = response.trajectory
    assert trajectory.joint_names == SIX
    assert trajectory.times[0] == 0.0
    assert np.diff(trajectory.times).min() > 0.0
    assert trajectory.positions[0] == pytest.approx(LEFT)
    assert trajectory.positions[-1] == pytest.approx(RIGHT, abs=1e-9)
    assert not trajectory.velocities[[0, -1]].any()
    assert response.planning_time > 0.0
    assert response.trajectory_start == pytest.approx(dict(zip(SIX, LEFT, strict=True)))


@pytest.mark.parametrize('seed', range(4))
def test_around_a_wall(wall, plan_for, clock, seed):
    """ADP-8: a trajectory round an obstacle is free by a judge of its own, within all limits."""
    response = plan_for(wall).plan(request(joint_goal(RIGHT), seed=seed), wall, clock=clock)
    assert response.success, response.message
    judge(response, wall.robot, [(WALL[0], pose_matrix(WALL[1]))])


@pytest.mark.parametrize(('planner', 'seconds'), [
    *((name, 0.1) for name in (
        'BiEST', 'BiTRRT', 'BITstar', 'BKPIECE', 'EST', 'KPIECE', 'LazyPRM', 'LazyPRMstar',
        'LazyRRT', 'LBKPIECE', 'LBTRRT', 'PDST', 'PRM', 'PRMstar', 'ProjEST', 'RRT', 'RRTConnect',
        'RRTstar', 'SBL', 'SPARS', 'SPARStwo', 'STRIDE', 'TRRT',
    )),
    ('BFMT', 1.0), ('FMT', 1.0),
])
def test_planners_of_all_types(wall, plan_for, clock, planner, seconds):
    """OMP-1: each of them finds a way round a wall."""
    settings = PlanningSettings({'ompl': PlanningPipeline(
        planners=PlannerTable({'arm': {'type': f'geometric::{planner}'}}))})
    response = plan_for(wall, settings).plan(
        request(joint_goal(RIGHT), allowed_planning_time=seconds), wall, clock=clock)
    assert response.success, response.message
    judge(response, wall.robot, [(WALL[0], pose_matrix(WALL[1]))], samples=60)


def test_thin_obstacle_is_not_jumped(six_scene, add_box, plan_for, clock):
    """OMP-4: a plate of 1 mm between start and goal is not overlooked."""
    add_box(six_scene, 'plate', (0.4, 0.001, 0.9), (0.5, 0.0, 0.45))
    response = plan_for(six_scene).plan(request(joint_goal(RIGHT)), six_scene, clock=clock)
    assert response.success, response.message
    plate = ((0.4, 0.001, 0.9), pose_matrix((0.5, 0.0, 0.45)))
    judge(response, six_scene.robot, [plate], samples=400)
    assert response.path_length > 1.9


def test_same_seed_same_trajectory(wall, plan_for, clock):
    """OMP-7: the same seed, scene and request give the same trajectory to the last bit."""
    first, second = (
        plan_for(wall).plan(request(joint_goal(RIGHT), seed=5), wall, clock=clock)
        for _ in range(2))
    other = plan_for(wall).plan(request(joint_goal(RIGHT), seed=6), wall, clock=clock)
    assert np.array_equal(first.trajectory.positions, second.trajectory.positions)
    assert np.array_equal(first.trajectory.times, second.trajectory.times)
    assert not np.array_equal(first.trajectory.positions[10], other.trajectory.positions[10])


def test_seed_of_the_settings(wall, plan_for, clock):
    """OMP-7: ``planning_seed`` holds for requests without a seed."""
    settings = PlanningSettings(seed=3)
    first, second = (
        plan_for(wall, settings).plan(request(joint_goal(RIGHT), seed=-1), wall, clock=clock)
        for _ in range(2))
    assert np.array_equal(first.trajectory.positions, second.trajectory.positions)


def test_settings_can_be_set_while_another_plans(wall, plan_for, clock):
    """Whoever sets them does not wait for the plan, which keeps those that it began with."""
    planner = plan_for(wall, PlanningSettings(seed=3))
    expected = planner.plan(request(joint_goal(RIGHT), seed=-1), wall, clock=clock)

    def set_another():
        planner.settings = PlanningSettings(seed=4, default_pipeline='nobody')
        return False

    answer = planner.plan(
        request(joint_goal(RIGHT), seed=-1), wall, clock=clock, cancelled=set_another)
    assert np.array_equal(answer.trajectory.positions, expected.trajectory.positions)
    assert planner.plan(request(joint_goal(RIGHT)), wall, clock=clock).error_code == 99999


def test_best_of_several_attempts(wall, plan_for, clock):
    """REQ-4: of several attempts the shortest path is returned."""
    planner = plan_for(wall)
    one = planner.plan(request(joint_goal(RIGHT), seed=2), wall, clock=clock)
    many = planner.plan(
        request(joint_goal(RIGHT), seed=2, num_planning_attempts=6), wall, clock=clock)
    assert many.path_length <= one.path_length


def test_already_there(six_scene, plan_for, clock):
    """ADP-6: a goal that is the start gives one point at time 0."""
    response = plan_for(six_scene).plan(request(joint_goal(LEFT)), six_scene, clock=clock)
    assert response.success
    assert len(response.trajectory) == 1
    assert response.trajectory.duration == 0.0


def test_scaling_factors(six_scene, plan_for, clock):
    """REQ-6: speed and acceleration follow their factors."""
    response = plan_for(six_scene).plan(
        request(joint_goal(RIGHT), max_velocity_scaling_factor=0.25,
                max_acceleration_scaling_factor=0.1), six_scene, clock=clock)
    velocities = np.abs(response.trajectory.velocities)
    accelerations = np.abs(response.trajectory.accelerations)
    assert 0.7 < velocities.max() <= 0.751
    assert 0.78 < accelerations.max() <= 0.801


@pytest.mark.parametrize('factor', [0.0, -1.0, 1.5, math.nan])
def test_impossible_scaling_factors_count_as_one(six_scene, plan_for, clock, log, factor):
    """REQ-6: values outside (0, 1] count as 1, with a warning."""
    response = plan_for(six_scene).plan(
        request(joint_goal(RIGHT), max_velocity_scaling_factor=factor), six_scene, clock=clock)
    velocities = np.abs(response.trajectory.velocities)
    assert velocities.max() == pytest.approx(3.0, rel=0.01)
    assert 'max_velocity_scaling_factor' in log.recorder.text()


def test_link_speed_limit(six, six_scene, plan_for, clock):
    """REQ-12: the limited link is no faster than max_cartesian_speed."""
    response = plan_for(six_scene).plan(
        request(joint_goal(RIGHT), max_cartesian_speed=0.2,
                cartesian_speed_limited_link='tool'), six_scene, clock=clock)
    times = np.linspace(0.0, response.trajectory.duration, 600)
    places = np.array([
        poses(six.robot, dict(zip(SIX, between(response.trajectory, t), strict=True)))['tool']
        for t in times])[:, :3, 3]
    speed = np.linalg.norm(np.diff(places, axis=0), axis=1) / (times[1] - times[0])
    assert 0.19 < speed.max() <= 0.202




def test_goal_reached(six_scene, plan_for):
    """ACT-4: whether the scene's state satisfies one of the goals."""
    planner = plan_for(six_scene)
    six_scene.set_positions(dict(zip(SIX, RIGHT, strict=True)))
    assert planner.goal_reached(request((joint_goal(LEFT), joint_goal(RIGHT))), six_scene)
    assert not planner.goal_reached(request(joint_goal(LEFT)), six_scene)


def test_goal_reached_satisfies_path_constraints(six_scene, plan_for):
    """
    A goal is reached where the state satisfies its and the path's constraints.

    Upstream: move_action_capability.cpp, executeMoveCallbackPlanAndExecute.
    """
    planner = plan_for(six_scene)
    six_scene.set_positions(dict(zip(SIX, RIGHT, strict=True)))
    goal = joint_goal(RIGHT[:1], SIX[:1])
    for kept, reached in ((RIGHT[1], True), (RIGHT[1] + 0.5, False)):
        asked = request(goal, path_constraints=joint_goal((kept,), SIX[1:2]))
        assert planner.goal_reached(asked, six_scene) is reached


def test_a_goal_without_usable_constraints_is_not_reached(six_scene, plan_for):
    """A goal of which no constraint can be used is planned, and refused there."""
    planner = plan_for(six_scene)
    assert not planner.goal_reached(request(joint_goal((0.0,), ('no_joint',))), six_scene)
    assert not planner.goal_reached(request(Constraints()), six_scene)


def test_rest_of_a_path_is_checked_without_padding(six_scene, add_box, plan_for, clock):
    """
    The rest of a path is checked for collisions of links that are not padded.

    Upstream: plan_execution.cpp, isRemainingPathValid.
    """
    planner = plan_for(six_scene)
    six_scene.set_positions(dict(zip(SIX, LEFT, strict=True)))
    trajectory = planner.plan(request(joint_goal(RIGHT)), six_scene, clock=clock).trajectory
    links = six_scene.link_padding
    thick = six_scene.with_update(SceneUpdate(
        link_padding=dict.fromkeys(links, 0.3), link_scale=dict.fromkeys(links, 1.2)))
    add_box(thick, 'near', (0.02, 0.02, 0.02), (0.5, 0.0, 0.7))
    middle = between(trajectory, 0.5 * trajectory.duration)
    thick.set_positions(dict(zip(SIX, middle, strict=True)))
    assert not planner.check_state(thick, thick.q, 'arm').valid
    assert planner.path_fault(trajectory, 0.0, thick, 'arm') == ''


def test_rest_of_a_path_when_the_world_changes(six_scene, add_box, plan_for, clock):
    """ACT-7: only what is left of a trajectory is looked at."""
    planner = plan_for(six_scene)
    six_scene.set_positions(dict(zip(SIX, LEFT, strict=True)))
    trajectory = planner.plan(request(joint_goal(RIGHT)), six_scene, clock=clock).trajectory
    assert planner.path_fault(trajectory, 0.0, six_scene, 'arm') == ''
    add_box(six_scene, 'late', (0.2, 0.02, 0.2), (0.5, 0.0, 0.4))
    assert "'late'" in planner.path_fault(trajectory, 0.0, six_scene, 'arm').replace('"', "'") \
        or 'late' in planner.path_fault(trajectory, 0.0, six_scene, 'arm')
    assert planner.path_fault(trajectory, 0.8 * trajectory.duration, six_scene, 'arm') == ''
