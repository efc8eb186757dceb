# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What triggers a new check of the remaining path."""

from types import SimpleNamespace

import numpy as np
import pytest
from rclpy.task import Future

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.model.geometry import Sphere
from armsim_ros.nodes.move_group.execution.trajectory_execution import PathWatch
from armsim_ros.planning.scene.content import FixedFrame
from armsim_ros.planning.scene.objects import CollisionObject, ObjectShape
from armsim_ros.planning.scene.planning_scene import PlanningScene

JOINTS = ('left_joint1', 'left_joint2')
BALL = CollisionObject('ball', shapes=(ObjectShape(Sphere(0.1)),))


@pytest.fixture(scope='module')
def kinematics():
    """Return a cell of two arms."""
    return KinematicModel(load_cell('two_bots').model)


@pytest.fixture
def context(kinematics):
    """Return two robots whose paths are always in the way of each other, and what is checked."""
    checked = []

    def submit(check):
        future = Future()
        future.set_result(check())
        return future

    arms = [frozenset(name for name in kinematics.names if name.startswith(arm))
            for arm in ('left', 'right')]
    return SimpleNamespace(
        robots=arms, checked=checked, scene=PlanningScene(kinematics),
        states=SimpleNamespace(positions=dict.fromkeys(kinematics.names, 0.0)),
        queries=SimpleNamespace(submit=submit))


@pytest.fixture
def watch(context):
    """Return a function that watches a motion that was planned in the scene as it is."""
    def fault(elapsed, scene):
        context.checked.append((elapsed, scene.content))
        return 'the other arm is in the way'

    present = context.scene.snapshot()
    return lambda planned_in=present: PathWatch(context, JOINTS, fault, planned_in)


@pytest.mark.parametrize(('joint', 'position', 'checks'), [
    ('right_joint1', 0.04, 1), ('right_joint1', -0.04, 1), ('right_joint1', 0.02, 0),
    ('left_joint1', 0.5, 0)])
def test_a_motion_of_another_robot_triggers_a_check(context, watch, joint, position, checks):
    """From 0.03 rad on; the motion of the robot itself does not."""
    path = watch()
    assert path.invalid(0.1) == ''
    context.states.positions[joint] = position
    assert path.invalid(0.2) == ''
    assert path.invalid(0.3) == ('the other arm is in the way' if checks else '')
    assert context.checked == [(0.2, context.scene.content)] * checks


@pytest.mark.parametrize('change', [
    lambda scene: scene.apply_object(BALL),
    lambda scene: scene.set_frames({'camera': FixedFrame('', np.eye(4))}),
], ids=['object', 'frame'])
def test_a_change_of_the_scene_triggers_one_check(context, watch, change):
    """A change of objects or of frames."""
    path = watch()
    change(context.scene)
    assert path.invalid(0.2) == ''
    assert path.invalid(0.3) == 'the other arm is in the way'
    assert path.invalid(0.4) == ''
    assert len(context.checked) == 1


def test_what_came_while_the_motion_was_planned_is_checked_at_once(context, watch):
    """
    The scene that counts is that of the plan, not that of the start of the motion.

    Upstream: plan_execution.cpp, planAndExecuteHelper (new_scene_update_).
    """
    context.scene.apply_object(BALL)
    path = watch()
    assert path.invalid(0.0) == ''
    assert path.invalid(0.1) == 'the other arm is in the way'


def test_a_motion_whose_plan_is_not_known_is_checked_at_its_start(context, watch):
    """
    Such as a part of a task's solution.

    Upstream: plan_execution.cpp, successfulTrajectorySegmentExecution.
    """
    path = watch(None)
    assert path.invalid(0.0) == ''
    assert path.invalid(0.1) == 'the other arm is in the way'
    assert path.invalid(0.2) == ''
