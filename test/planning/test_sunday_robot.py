# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of planning for the robot that comes with the package, from its own files."""

from itertools import pairwise

import numpy as np
import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.kinematics.planning_limits import planning_robot
from armsim_ros.model.loading import load_robot_model
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.context import settings_from_config
from armsim_ros.planning.planner import MotionPlanner
from armsim_ros.planning.request import (
    CartesianRequest,
    Constraints,
    JointConstraint,
    MotionPlanRequest,
)
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import StartState

GROUP = 'manipulator'


@pytest.fixture(scope='module')
def settings():
    """Return the robot's files, read."""
    return load_robot_settings('sunday')


@pytest.fixture(scope='module')
def model(settings):
    """Return the robot's kinematics."""
    return KinematicModel(planning_robot(load_robot_model(settings), settings.joint_limits))


@pytest.fixture
def scene(model):
    """Return an empty scene with the robot."""
    return PlanningScene(model)


@pytest.fixture
def planner(scene, settings, log):
    """Return a planner with the settings of the robot's files."""
    return MotionPlanner(scene, settings=settings_from_config(
        settings.planning_parameters, settings.pipelines, settings.kinematics), log=log)


@pytest.fixture
def request_for(model):
    """Return a function that asks for a motion between two named states, as RViz does."""
    states = model.robot.semantic.named_states[GROUP]

    def make(start, goal, **options):
        joints = tuple(
            JointConstraint(name, value, 1e-4, 1e-4) for name, value in states[goal].items())
        return MotionPlanRequest(
            GROUP, (Constraints(joints),), StartState.from_positions(states[start]),
            seed=1, **options)
    return make


def test_scan_food(planner, scene, model, request_for, clock):
    """SEED-1: the stored state scan_food can be planned to from home."""
    response = planner.plan(request_for('home', 'scan_food'), scene, clock=clock)
    assert response.success, response.message
    end = dict(zip(
        response.trajectory.joint_names, response.trajectory.positions[-1], strict=True))
    assert end == pytest.approx(model.robot.semantic.named_states[GROUP]['scan_food'], abs=1e-4)


def test_a_round_through_all_named_states(planner, scene, model, request_for, clock):
    """Every named state is reached from the one before, and the motion between is free."""
    judge = CollisionChecker(scene)
    names = [*model.robot.semantic.named_states[GROUP], 'home']
    for start, goal in pairwise(names):
        response = planner.plan(request_for(start, goal), scene, clock=clock)
        assert response.success, f'{start} to {goal}: {response.message}'
        for a, b in pairwise(response.trajectory.positions):
            for part in np.linspace(0.0, 1.0, 4):
                q = model.insert(model.default(), GROUP, a + part * (b - a))
                assert not judge.in_collision(q)


@pytest.mark.parametrize('planner_id', [
    'RRTConnect', 'RRTConnectkConfigDefault', 'manipulator[RRTConnect]', 'EST', 'SBL', ''])
def test_planners_of_the_file(planner, scene, request_for, clock, planner_id):
    """CFG-7: ids of ompl_planning.yaml plan, and others with the group's default."""
    response = planner.plan(
        request_for('scan_food', 'home', planner_id=planner_id), scene, clock=clock)
    assert response.success, response.message


def test_down_to_the_table(planner, scene, model):
    """A straight line down from scan_food, as a pick needs it."""
    scene.set_positions(model.robot.semantic.named_states[GROUP]['scan_food'])
    tip = model.robot.semantic.groups[GROUP].tips[-1]
    goal = scene.frame_pose(tip).copy()
    goal[2, 3] -= 0.05
    response = planner.cartesian_path(CartesianRequest(GROUP, (goal,), 0.1, tip), scene)
    assert response.error_code == 1
    assert response.fraction == pytest.approx(1.0)


def test_an_object_in_the_way(planner, scene, request_for, add_box, clock):
    """A box where the straight motion would pass is gone round."""
    free = planner.plan(request_for('scan_food', 'scan_face2'), scene, clock=clock)
    middle = free.trajectory.positions[len(free.trajectory) // 2]
    model = scene.kinematic_model
    tip = model.robot.semantic.groups[GROUP].tips[-1]
    place = model.link_pose(model.insert(model.default(), GROUP, middle), tip)[:3, 3]
    add_box(scene, 'ball', (0.06, 0.06, 0.06), place)
    response = planner.plan(request_for('scan_food', 'scan_face2'), scene, clock=clock)
    assert response.success, response.message
    assert response.path_length > free.path_length
    judge = CollisionChecker(scene)
    for positions in response.trajectory.positions:
        assert not judge.in_collision(model.insert(model.default(), GROUP, positions))


def test_attached_object_is_planned_with(planner, scene, request_for, add_box, clock):
    """SCN-10: an attached object takes part in collision checks of the plan."""
    from armsim_ros.planning.scene.update import AttachedObject, CollisionObject
    tip = scene.robot.semantic.groups[GROUP].tips[-1]
    scene.set_positions(scene.robot.semantic.named_states[GROUP]['scan_food'])
    place = scene.frame_pose(tip) @ pose_matrix((0.0, 0.0, 0.0))
    add_box(scene, 'tray', (0.9, 0.9, 0.02), place[:3, 3])
    scene.apply_attached(AttachedObject(tip, CollisionObject('tray', 0)))
    response = planner.plan(request_for('scan_food', 'home'), scene, clock=clock)
    assert response.error_code in (-10, -12)
    assert "'tray'" in response.message
