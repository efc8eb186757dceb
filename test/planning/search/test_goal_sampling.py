# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of goals for joints and links, and of what has to hold on the way to them."""

from dataclasses import replace
import math

import numpy as np
import pytest
from six_axis_requests import joint_goal, LEFT, pose_goal, request, RIGHT, SIX
from trajectory_judge import between, poses

from armsim_ros.errors import MoveItErrorCode
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Box, Sphere
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.budget import Budget
from armsim_ros.planning.constraints import ConstraintSet
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.planner import never
from armsim_ros.planning.request import (
    Constraints,
    JointConstraint,
    MotionPlanRequest,
    OrientationConstraint,
    PositionConstraint,
    Region,
)
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import StartState
from armsim_ros.planning.search.goal_sampling import GoalSampler


def test_pose_goal(six, six_scene, plan_for, clock):
    """CON-7: a pose goal is reached within its tolerances, by forward kinematics of its own."""
    wanted = poses(six.robot, dict(zip(SIX, (0.4, 0.9, 0.8, 0.3, 0.5, -0.2), strict=True)))['tool']
    response = plan_for(six_scene).plan(request(pose_goal(wanted)), six_scene, clock=clock)
    assert response.success, response.message
    end = dict(zip(SIX, response.trajectory.positions[-1], strict=True))
    reached = poses(six.robot, end)['tool']
    assert np.linalg.norm(reached[:3, 3] - wanted[:3, 3]) < 1e-4
    assert reached[:3, :3] == pytest.approx(wanted[:3, :3], abs=1e-3)


def test_pose_goal_for_another_link(six, six_scene, plan_for, clock):
    """CON-7: the constrained link may be any link fixed to the tip, or one before it."""
    wanted = poses(six.robot, dict(zip(SIX, (0.4, 0.9, 0.8, 0.3, 0.5, 0.0), strict=True)))
    response = plan_for(six_scene).plan(
        request(pose_goal(wanted['segment6'], 'segment6')), six_scene, clock=clock)
    assert response.success, response.message
    end = dict(zip(SIX, response.trajectory.positions[-1], strict=True))
    assert poses(six.robot, end)['segment6'] == pytest.approx(wanted['segment6'], abs=1e-3)


@pytest.mark.parametrize('seed', range(6))
def test_pose_goal_of_a_subgroup_leaves_the_others(pair, pair_scene, plan_for, clock, seed):
    """
    A pose goal for one arm of a group of two leaves the other arm at its start.

    moveit_core, constraint_sampler_manager.cpp, selectDefaultSampler: the subgroup that holds
    the link samples, the joints of other subgroups keep the values of the start state.
    """
    start = pair_scene.q.copy()
    rng = np.random.default_rng(seed)
    q = pair.insert(start, 'left', rng.uniform(-1.0, 1.0, 6))
    goal = pose_goal(pair.link_pose(q, 'left_tool'), 'left_tool')
    goal = replace(
        goal, position_constraints=(replace(goal.position_constraints[0], frame_id='world'),),
        orientation_constraints=(replace(goal.orientation_constraints[0], frame_id='world'),))
    response = plan_for(pair_scene).plan(
        MotionPlanRequest('both', (goal,), seed=seed), pair_scene, clock=clock)
    assert response.success, response.message
    end = pair.vector(dict(zip(
        response.trajectory.joint_names, response.trajectory.positions[-1], strict=True)))
    assert pair.extract(end, 'right') == pytest.approx(pair.extract(start, 'right'), abs=1e-12)


def test_position_goal(six, six_scene, plan_for, clock):
    """CON-7: a position alone leaves the orientation free."""
    region = Region(Sphere(1e-3), pose_matrix((0.4, 0.2, 0.5)))
    goal = Constraints(position_constraints=(PositionConstraint('tool', (region,), 'base'),))
    response = plan_for(six_scene).plan(request(goal), six_scene, clock=clock)
    assert response.success, response.message
    end = dict(zip(SIX, response.trajectory.positions[-1], strict=True))
    assert poses(six.robot, end)['tool'][:3, 3] == pytest.approx((0.4, 0.2, 0.5), abs=1e-3)


def test_orientation_goal(six, six_scene, plan_for, clock):
    """CON-7: an orientation alone leaves the position free."""
    goal = Constraints(orientation_constraints=(
        OrientationConstraint('tool', (1.0, 0.0, 0.0, 0.0), (0.01,) * 3, 'base'),))
    response = plan_for(six_scene).plan(request(goal), six_scene, clock=clock)
    assert response.success, response.message
    end = dict(zip(SIX, response.trajectory.positions[-1], strict=True))
    down = poses(six.robot, end)['tool'][:3, :3]
    assert down == pytest.approx(np.diag([1.0, -1.0, -1.0]), abs=0.02)


def test_goal_of_some_joints(six_scene, plan_for, clock):
    """CON-7: joints that the goal does not name stay where they are if they can."""
    response = plan_for(six_scene).plan(
        request(joint_goal((0.5,), ('axis1',))), six_scene, clock=clock)
    assert response.trajectory.positions[-1] == pytest.approx((0.5, *LEFT[1:]), abs=1e-9)


def test_wide_joint_goal_is_met_in_its_middle(six_scene, plan_for, clock):
    """CON-7: a goal for all joints is met at its positions where these are free."""
    response = plan_for(six_scene).plan(
        request(joint_goal(RIGHT, tolerance=0.05)), six_scene, clock=clock)
    assert response.trajectory.positions[-1] == pytest.approx(RIGHT, abs=1e-9)


def test_wide_joint_goal_with_its_middle_blocked(six_scene, add_box, plan_for, clock):
    """CON-7: where the middle collides another state of the box is taken."""
    planner = plan_for(six_scene)
    model = six_scene.kinematic_model
    middle = model.vector(dict(zip(SIX, RIGHT, strict=True)))
    tip = model.link_pose(middle, 'tool')[:3, 3]
    add_box(six_scene, 'block', (0.12, 0.12, 0.12), tip)
    assert not planner.check_state(six_scene, middle, 'arm').valid
    response = planner.plan(
        request(joint_goal(RIGHT, tolerance=0.5)), six_scene, clock=clock)
    assert response.success, response.message
    assert np.abs(response.trajectory.positions[-1] - np.array(RIGHT)).max() <= 0.5


@pytest.mark.parametrize('regions', [
    [(Box((0.3, 0.3, 1.4)), 0.6)], [(Sphere(1e-3), 0.6), (Sphere(1e-3), 0.0)]])
def test_a_goal_whose_middle_is_out_of_reach(six, six_scene, plan_for, clock, regions):
    """A pose with room in its position is reached elsewhere in its regions."""
    def plan(goal):
        return plan_for(six_scene).plan(
            request(goal, allowed_planning_time=60.0), six_scene, clock=clock)

    pose = poses(six.robot, dict(zip(SIX, (0.4, 0.9, 0.8, 0.3, 0.5, -0.2), strict=True)))['tool']
    assert plan(pose_goal(pose_matrix((0.0, 0.0, 0.6)) @ pose)).error_code == -31
    goal = pose_goal(pose)
    position, = goal.position_constraints
    wide = replace(position, regions=tuple(
        Region(shape, pose_matrix(pose[:3, 3] + (0.0, 0.0, above))) for shape, above in regions))
    response = plan(replace(goal, position_constraints=(wide,)))
    assert response.success, response.message


def test_goals_are_alternatives(wall, add_box, plan_for, clock):
    """REQ-8: of several goals one that is free is enough."""
    add_box(wall, 'block', (0.2, 0.2, 0.2), (0.45, 0.55, 0.4))
    goals = (joint_goal((0.9, 1.2, 0.3, 0.0, 0.5, 0.0)), joint_goal((1.6, 0.4, 0.3, 0, 0.5, 0)))
    response = plan_for(wall).plan(request(goals), wall, clock=clock)
    assert response.success, response.message


def test_continuous_joints_take_the_short_way(turning, plan_for, clock):
    """CON-1: a continuous joint turns the short way to its goal, over half a turn if need be."""
    scene = PlanningScene(KinematicModel(turning))
    names = ('axis1', 'axis2', 'axis3')
    response = plan_for(scene).plan(MotionPlanRequest(
        'arm', (joint_goal((-3.0, 0.5, 0.0), names),), StartState(names, (3.0, 0.5, 0.0)), seed=1),
        scene, clock=clock)
    assert response.success, response.message
    assert response.path_length == pytest.approx(2 * math.pi - 6.0, abs=1e-6)


def test_orientation_is_kept_on_the_way(six, six_scene, plan_for, clock):
    """REQ-9: a path constraint on orientation holds all along the trajectory."""
    start = (-0.7, 0.6, 1.0, 0.0, math.pi - 1.6, 0.0)
    goal = (0.8, 0.9, 0.9, 0.0, math.pi - 1.8, 0.0)
    keep = Constraints(orientation_constraints=(
        OrientationConstraint('tool', (0.0, 1.0, 0.0, 0.0), (0.05, 0.05, 3.1416), 'base'),))
    response = plan_for(six_scene).plan(
        request(joint_goal(goal), start, path_constraints=keep), six_scene, clock=clock)
    assert response.success, response.message
    for t in np.linspace(0.0, response.trajectory.duration, 200):
        named = dict(zip(SIX, between(response.trajectory, t), strict=True))
        tilt = poses(six.robot, named)['tool'][:3, 2]
        assert math.acos(min(1.0, -tilt[2])) < 0.0725


def test_start_that_breaks_path_constraints(six_scene, plan_for, clock):
    """E5: a start that violates the path constraints is refused with -11 and the constraint."""
    keep = Constraints((JointConstraint('axis1', 0.0, 0.1, 0.1),))
    response = plan_for(six_scene).plan(
        request(joint_goal(RIGHT), path_constraints=keep), six_scene, clock=clock)
    assert response.error_code == -11
    assert "'axis1' is at -0.9000" in response.message


def test_goal_that_breaks_path_constraints(six_scene, plan_for, clock):
    """A goal pose that no state within the path constraints reaches is refused with -13."""
    keep = Constraints(position_constraints=(PositionConstraint(
        'tool', (Region(Box((2.0, 1.0, 2.0)), pose_matrix((0.0, -0.5, 0.5))),), 'base'),))
    response = plan_for(six_scene).plan(
        request(joint_goal(RIGHT), path_constraints=keep), six_scene, clock=clock)
    assert response.error_code == -13
    assert "'tool'" in response.message


def test_joint_goal_with_an_orientation_is_sampled_in_joint_space(six_scene, plan_for, clock):
    """
    A goal that names all joints is met at them; its other constraints are checked.

    Upstream: constraint_sampler_manager.cpp, selectDefaultSampler.
    """
    level = OrientationConstraint('tool', (0.0, 0.0, 0.0, 1.0), (4.0,) * 3, 'base')
    goal = joint_goal(RIGHT)
    for orientations, code in (((level, level), 1), ((level, replace(
            level, tolerances=(0.01,) * 3)), -16)):
        response = plan_for(six_scene).plan(
            request(replace(goal, orientation_constraints=orientations)), six_scene, clock=clock)
        assert response.error_code == code


def test_the_narrowest_constraint_of_a_link_is_sampled(six, six_scene, plan_for, clock):
    """
    Of two orientations for a link the narrower one is sampled; the end satisfies both.

    Upstream: constraint_sampler_manager.cpp, selectDefaultSampler.
    """
    pose = poses(six.robot, dict(zip(SIX, (0.4, 0.9, 0.8, 0.3, 0.5, -0.2), strict=True)))['tool']
    goal = pose_goal(pose)
    narrow, = goal.orientation_constraints
    wide = replace(narrow, tolerances=(0.5, 0.5, 0.5))
    goal = replace(goal, orientation_constraints=(wide, narrow))
    response = plan_for(six_scene).plan(request(goal), six_scene, clock=clock)
    assert response.success, response.message
    end = dict(zip(SIX, response.trajectory.positions[-1], strict=True))
    assert poses(six.robot, end)['tool'] == pytest.approx(pose, abs=2e-3)


def test_a_position_goal_with_an_orientation_kept_on_the_way(six, six_scene, plan_for, clock):
    """
    A goal of a position alone is sampled with the orientation of the path constraints.

    Upstream: model_based_planning_context.cpp, setGoalConstraints.
    """
    start = (-0.7, 0.6, 1.0, 0.0, math.pi - 1.6, 0.0)
    keep = Constraints(orientation_constraints=(
        OrientationConstraint('tool', (0.0, 1.0, 0.0, 0.0), (0.05, 0.05, 3.1416), 'base'),))
    tip = poses(six.robot, dict(zip(SIX, start, strict=True)))['tool'][:3, 3]
    region = Region(Sphere(1e-3), pose_matrix((tip[0], -tip[1], tip[2] + 0.03)))
    goal = Constraints(position_constraints=(PositionConstraint('tool', (region,), 'base'),))
    response = plan_for(six_scene).plan(
        request(goal, start, path_constraints=keep), six_scene, clock=clock)
    assert response.success, response.message


BENT = (0.4, 0.9, 0.8, 0.3, 0.5, -0.2)


def spinning(pose, axis):
    """Return a goal for a pose of the tool, which may spin about an axis of its own."""
    goal = pose_goal(pose)
    tolerances = [0.01, 0.01, 0.01]
    tolerances[axis] = 3.1416
    orientation, = goal.orientation_constraints
    return replace(goal, orientation_constraints=(
        replace(orientation, tolerances=tuple(tolerances), parameterization=0),))


def tilt(six, state, pose, axis):
    """Return the angle between an axis of the tool and the same axis of a pose [rad]."""
    reached = poses(six.robot, dict(zip(SIX, state, strict=True)))['tool']
    return math.acos(min(1.0, reached[:3, axis] @ pose[:3, axis]))


@pytest.mark.parametrize('axis', [0, 2])
def test_goal_of_a_tool_that_may_spin_about_its_own_axis(six, six_scene, plan_for, clock, axis):
    """
    A wide tolerance about x or z leaves that axis of the link where the goal points it.

    Upstream: kinematic_constraint.cpp, OrientationConstraint::decide.
    """
    pose = poses(six.robot, dict(zip(SIX, BENT, strict=True)))['tool']
    answer = plan_for(six_scene).plan(request(spinning(pose, axis)), six_scene, clock=clock)
    assert answer.success, answer.message
    assert tilt(six, answer.trajectory.positions[-1], pose, axis) < 0.0145


@pytest.mark.parametrize('axis', [0, 2])
def test_path_of_a_tool_that_may_spin_about_its_own_axis(six, six_scene, plan_for, clock, axis):
    """
    The axis points the same way all along a path with such a constraint.

    Upstream: kinematic_constraint.cpp, OrientationConstraint::decide.
    """
    pose = poses(six.robot, dict(zip(SIX, BENT, strict=True)))['tool']
    there = pose.copy()
    there[:3, 3] += (0.0, -0.1, 0.03)
    goal = spinning(there, axis)
    kept = Constraints(orientation_constraints=goal.orientation_constraints)
    answer = plan_for(six_scene).plan(
        request(goal, BENT, path_constraints=kept), six_scene, clock=clock)
    assert answer.success, answer.message
    for t in np.linspace(0.0, answer.trajectory.duration, 99):
        assert tilt(six, between(answer.trajectory, t), pose, axis) < 0.0145


def place_goal(six, state):
    """Return a goal for the place of the tool in a state, in any orientation."""
    point = six.link_pose(six.vector(dict(zip(SIX, state, strict=True))), 'tool')[:3, 3]
    region = Region(Sphere(5e-4), pose_matrix(point))
    return Constraints(position_constraints=(PositionConstraint('tool', (region,), 'base'),))


@pytest.mark.parametrize('seed', [0, 1, 3])
@pytest.mark.parametrize('on_path', [False, True])
def test_pose_goal_with_a_joint_constraint(six, six_scene, plan_for, clock, on_path, seed):
    """
    Of the states for a pose one is taken whose joint is within its narrow interval.

    Upstream: constraint_sampler_manager.cpp, selectDefaultSampler (UnionConstraintSampler).
    """
    state = np.array(LEFT) + np.random.default_rng(seed).uniform(-0.6, 0.6, 6)
    if on_path:
        state[1] = LEFT[1]
    goal = place_goal(six, state)
    joint = Constraints((JointConstraint('axis2', float(state[1]), 0.005, 0.005),))
    if on_path:
        asked = request(goal, path_constraints=joint)
    else:
        asked = request(replace(goal, joint_constraints=joint.joint_constraints))
    response = plan_for(six_scene).plan(asked, six_scene, clock=clock)
    assert response.success, response.message
    assert response.trajectory.positions[-1][1] == pytest.approx(state[1], abs=0.005001)


def test_sampling_goes_on_where_the_first_draws_miss(six, six_scene, log, clock):
    """
    A state that few of those for a pose satisfy is found by further draws.

    Upstream: constrained_goal_sampler.cpp, sampleUsingConstraintSampler.
    """
    state = np.array(BENT)
    elbow = six.link_pose(six.vector(dict(zip(SIX, BENT, strict=True))), 'segment4')[:3, 3]
    path = ConstraintSet(Constraints(position_constraints=(PositionConstraint(
        'segment4', (Region(Sphere(0.01), pose_matrix(elbow)),), 'base'),)), six_scene, log)
    goal = ConstraintSet(replace(place_goal(six, state), joint_constraints=(
        JointConstraint('axis1', float(state[0]), 0.5, 0.5),)), six_scene, log)
    context = PlanningContext(six_scene)
    sampler = GoalSampler(
        six, context.inverse('arm'), context.validity(six_scene, 'arm', path), six_scene.q,
        np.random.default_rng(1))
    found = sampler.sample([goal], Budget(clock, 50.0, never))
    assert path.satisfied(found[0])


def test_pose_goal_that_its_joint_constraint_excludes(six, six_scene, plan_for, clock):
    """A pose that can be reached, but not with the joint where it has to be, names the joint."""
    pose = six.link_pose(six.vector(dict(zip(SIX, BENT, strict=True))), 'tool')
    goal = replace(
        pose_goal(pose), joint_constraints=(JointConstraint('axis2', -1.5, 0.01, 0.01),))
    response = plan_for(six_scene).plan(request(goal), six_scene, clock=clock)
    assert response.error_code == MoveItErrorCode.INVALID_GOAL_CONSTRAINTS
    assert "joint 'axis2'" in response.message


@pytest.mark.parametrize('seed', range(3))
def test_goal_of_some_joints_with_an_orientation_kept_on_the_way(
    six, six_scene, plan_for, clock, seed
):
    """
    The joints that a goal does not name take values that keep the orientation of the path.

    Upstream: model_based_planning_context.cpp, setGoalConstraints (mergeConstraints).
    """
    start = (0.3, 0.7, 1.2, 0.0, 1.24159, 0.1)
    pose = six.link_pose(six.vector(dict(zip(SIX, start, strict=True))), 'tool')
    level, = pose_goal(pose).orientation_constraints
    keep = Constraints(orientation_constraints=(replace(level, tolerances=(0.1, 0.1, 3.14)),))
    goal = joint_goal((0.2,), ('axis2',), tolerance=0.2)
    response = plan_for(six_scene).plan(
        request(goal, start, path_constraints=keep, seed=seed), six_scene, clock=clock)
    assert response.success, response.message
    assert abs(response.trajectory.positions[-1][1] - 0.2) < 0.2001
