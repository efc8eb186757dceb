# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What triggers a new check of the remaining path."""

from types import SimpleNamespace

import numpy as np
import pytest
from rclpy.task import Future

from armsim_ros.nodes.move_group.execution.trajectory_execution import PathWatch
from armsim_ros.trajectory import JointTrajectory

MOTION = JointTrajectory(
    ('left_1', 'left_2'), np.array([0.0, 1.0]), np.array([[0.0, 0.0], [1.0, 1.0]]))


@pytest.fixture
def context():
    """Return two robots whose paths are always in the way of each other, and what is checked."""
    checked = []

    def submit(check):
        future = Future()
        future.set_result(check())
        return future

    def path_fault(*given):
        checked.append(given)
        return 'the other arm is in the way'

    return SimpleNamespace(
        robots=[{'left_1', 'left_2'}, {'right_1'}], checked=checked,
        states=SimpleNamespace(positions={'left_1': 0.0, 'left_2': 0.0, 'right_1': 0.0}),
        scene=SimpleNamespace(geometry_version=0, transform_version=0, snapshot=lambda: 'scene'),
        queries=SimpleNamespace(submit=submit),
        query_planner=SimpleNamespace(path_fault=path_fault))


@pytest.mark.parametrize(('joint', 'position', 'checks'), [
    ('right_1', 0.04, 1), ('right_1', -0.04, 1), ('right_1', 0.02, 0), ('left_1', 0.5, 0)])
def test_a_motion_of_another_robot_triggers_a_check(context, joint, position, checks):
    """From 0.03 rad on; the motion of the robot itself does not."""
    watch = PathWatch(context, MOTION, 'left', lambda scene: scene)
    assert watch.invalid(0.1) == ''
    context.states.positions[joint] = position
    assert watch.invalid(0.2) == ''
    assert watch.invalid(0.3) == ('the other arm is in the way' if checks else '')
    assert context.checked == [(MOTION, 0.2, 'scene', 'left')] * checks


def test_a_change_of_the_scene_triggers_a_check(context):
    """A change of objects or of frames."""
    watch = PathWatch(context, MOTION, 'left', lambda scene: scene)
    for name in ('geometry_version', 'transform_version'):
        setattr(context.scene, name, 1)
        assert watch.invalid(0.2) == ''
        assert watch.invalid(0.3) == 'the other arm is in the way'
