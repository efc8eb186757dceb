# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of goals of joints that turn more than once: the other way round."""

import math

import numpy as np
import pytest
from small_arms import planar_arm, turning_arm

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.robot_model import JointLimits
from armsim_ros.planning.budget import Budget
from armsim_ros.planning.constraints import ConstraintSet
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.planner import never
from armsim_ros.planning.request import Constraints, JointConstraint, MotionPlanRequest
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.search.goal_sampling import GoalSampler

TURN = 2.0 * math.pi
NAMES = ('axis1', 'axis2', 'axis3')
FAR = np.array([2.5, 0.0, 0.0])
WALL_AT = 1.2


@pytest.fixture
def endless():
    """Return a scene with an arm whose joints turn without end."""
    return PlanningScene(KinematicModel(turning_arm()))


@pytest.fixture
def twice():
    """Return a scene with an arm whose joints turn once to either side."""
    return PlanningScene(KinematicModel(planar_arm(limits=JointLimits(-6.28, 6.28, 3.0, 8.0))))


@pytest.fixture
def add_wall(add_box):
    """Put a wall across the short way to FAR into a scene."""
    def add(scene):
        x, y = 0.65 * math.cos(WALL_AT), 0.65 * math.sin(WALL_AT)
        add_box(scene, 'wall', (1.1, 0.03, 0.4), (x, y, 0.0), (0.0, 0.0, WALL_AT))
    return add


def pose_of(scene, values):
    """Return a goal for the pose of the tool in a state."""
    return Constraints.of_pose(
        'tool', scene.kinematic_model.link_pose(values, 'tool'), scene.model_frame)


@pytest.mark.parametrize('turns', [0, 1])
def test_continuous_joint_takes_the_long_way_where_the_short_is_blocked(
    endless, add_wall, plan_for, clock, turns
):
    """
    A goal of a continuous joint is reached round the other side.

    Upstream: revolute_joint_model.cpp, interpolate and distance.
    """
    add_wall(endless)
    goal = Constraints.of_joints(dict(zip(NAMES, FAR - (turns * TURN, 0.0, 0.0), strict=True)))
    response = plan_for(endless).plan(
        MotionPlanRequest('arm', (goal,), seed=1), endless, clock=clock)
    assert response.success, response.message
    assert response.trajectory.positions[-1][0] == pytest.approx(FAR[0] - TURN, abs=1e-3)


def test_pose_goal_is_reached_the_other_way_round(twice, add_wall, plan_for, clock):
    """A pose goal is reached a turn away, within the limits."""
    add_wall(twice)
    response = plan_for(twice).plan(
        MotionPlanRequest('arm', (pose_of(twice, FAR),), seed=1), twice, clock=clock)
    assert response.success, response.message
    assert response.trajectory.positions[-1][0] < 0.0


def test_short_way_is_taken_round_an_obstacle(endless, add_box, plan_for, clock):
    """A detour that leads the short way is preferred to a whole turn."""
    add_box(endless, 'post', (0.06, 0.06, 0.4), (0.75 * math.cos(1.2), 0.75 * math.sin(1.2), 0.0))
    goal = Constraints.of_joints(dict(zip(NAMES, FAR, strict=True)))
    response = plan_for(endless).plan(
        MotionPlanRequest('arm', (goal,), seed=1), endless, clock=clock)
    assert response.success, response.message
    assert response.trajectory.positions[-1] == pytest.approx(FAR, abs=1e-3)


@pytest.fixture
def turned(clock, log):
    """Return a function that returns a goal's states and those a turn away."""
    def make(scene, constraints):
        context = PlanningContext(scene)
        sampler = GoalSampler(
            scene.kinematic_model, context.inverse('arm'), context.validity(scene, 'arm'),
            scene.q, np.random.default_rng(1))
        goals = [ConstraintSet(constraints, scene, log)]
        states = sampler.sample(goals, Budget(clock, 5.0, never))
        return states, sampler.turned(goals, states)
    return make


def test_turned_states_satisfy_the_goal_within_the_limits(twice, turned):
    """States a turn away have the same pose, and are within the limits."""
    constraints = pose_of(twice, FAR)
    states, others = turned(twice, constraints)
    assert others
    model = twice.kinematic_model
    for values in others:
        assert model.within_limits(values)
        assert min(np.abs(values - state).sum() for state in states) == pytest.approx(TURN)


def test_joint_goal_within_limits_is_meant_literally(twice, turned):
    """
    A joint with limits that is a turn away from its goal is not there.

    Upstream: kinematic_constraint.cpp, JointConstraint::decide.
    """
    joints = tuple(
        JointConstraint(name, float(value), 0.01, 0.01)
        for name, value in zip(NAMES, FAR, strict=True))
    _, others = turned(twice, Constraints(joints))
    assert not others
