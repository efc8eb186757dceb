# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Starts that are not valid, repaired where the user asks for it."""

from __future__ import annotations

from dataclasses import replace
import time

import numpy as np
import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.config.ompl_planning import PipelineSettings, PlanningParameters
from armsim_ros.errors import MoveItErrorCode
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.kinematics.planning_limits import planning_robot
from armsim_ros.model.geometry import Box
from armsim_ros.model.loading import load_robot_model
from armsim_ros.model.transforms import pose_from_parts
from armsim_ros.planning.context import settings_from_config
from armsim_ros.planning.planner import MotionPlanner
from armsim_ros.planning.request import Constraints, JointConstraint, MotionPlanRequest
from armsim_ros.planning.scene.objects import CollisionObject, ObjectShape
from armsim_ros.planning.scene.planning_scene import PlanningScene

GROUP = 'manipulator'
START = (0.3, -0.9, 1.2, 0.2, 0.9, 0.1)
ADAPTERS = (
    'default_planner_request_adapters/FixStartStateCollision',
    'default_planner_request_adapters/FixStartStatePathConstraints',
)


@pytest.fixture(scope='module')
def model() -> KinematicModel:
    """Give a UR5."""
    settings = load_robot_settings('ur5')
    return KinematicModel(planning_robot(load_robot_model(settings), settings.joint_limits))


@pytest.fixture
def scene(model: KinematicModel) -> PlanningScene:
    """Give an empty world with the robot at its start."""
    scene = PlanningScene(model)
    scene.set_state(model.insert(model.default(), GROUP, START))
    return scene


def planner(scene: PlanningScene, *adapters: str) -> MotionPlanner:
    """Return a planner with these request adapters."""
    settings = settings_from_config(
        PlanningParameters(planning_pipelines=('ompl',)),
        {'ompl': PipelineSettings(request_adapters=adapters, planning_seed=3)}, {})
    return MotionPlanner(scene, settings=settings)


def touching_box(scene: PlanningScene) -> None:
    """Put a box so that the arm just touches it."""
    tip = scene.frame_pose('tool0')[:3, 3]
    pose = pose_from_parts(tip + np.array([0.0, 0.0, -0.2]), np.eye(3))
    size, judge = 0.02, planner(scene)
    while size < 0.5:
        scene.apply_object(CollisionObject(
            'box', pose=pose, shapes=(ObjectShape(Box((size, size, size)), np.eye(4)),)))
        if judge.check_state(scene.snapshot(), scene.q).contacts:
            return
        size += 0.005
    raise AssertionError('the box never touches')


def request(scene: PlanningScene, value: float = 0.6) -> MotionPlanRequest:
    """Return a request to turn the first joint."""
    joint = scene.robot.semantic.groups[GROUP].active_joints[0]
    goal = Constraints(joint_constraints=(JointConstraint(joint, value, 1e-3, 1e-3),))
    return MotionPlanRequest(GROUP, (goal,))


def test_a_colliding_start_stays_an_error_unless_repair_is_asked_for(
    scene: PlanningScene,
) -> None:
    """ADP-4: without the adapter the start collides."""
    touching_box(scene)
    answer = planner(scene).plan(request(scene), scene.snapshot(), clock=time.monotonic)
    assert answer.error_code == MoveItErrorCode.START_STATE_IN_COLLISION


def test_a_colliding_start_is_left_first(scene: PlanningScene) -> None:
    """SEED-10: FixStartStateCollision moves out of the collision, then on."""
    touching_box(scene)
    answer = planner(scene, ADAPTERS[0]).plan(
        request(scene), scene.snapshot(), clock=time.monotonic
    )
    assert answer.success, answer.message
    positions = answer.trajectory.positions
    assert positions[0] == pytest.approx(START)
    assert np.all(np.diff(answer.trajectory.times) > 0.0)
    assert positions[-1, 0] == pytest.approx(0.6, abs=2e-3)


def test_a_start_off_the_path_constraints_is_brought_to_them(scene: PlanningScene) -> None:
    """SEED-10: FixStartStatePathConstraints moves to the constraints, then keeps them."""
    elbow = scene.robot.semantic.groups[GROUP].active_joints[2]
    kept = Constraints(joint_constraints=(JointConstraint(elbow, 1.4, 0.1, 0.1),))
    wanted = replace(request(scene), path_constraints=kept)
    plain = planner(scene).plan(wanted, scene.snapshot(), clock=time.monotonic)
    assert plain.error_code == MoveItErrorCode.START_STATE_VIOLATES_PATH_CONSTRAINTS
    answer = planner(scene, ADAPTERS[1]).plan(wanted, scene.snapshot(), clock=time.monotonic)
    assert answer.success, answer.message
    elbows = answer.trajectory.positions[:, 2]
    arrived = int(np.argmax(elbows >= 1.3 - 1e-6))
    assert np.all(elbows[arrived:] >= 1.3 - 1e-3)
    assert answer.trajectory.positions[0] == pytest.approx(START)
