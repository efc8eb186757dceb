# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The start states of questions and requests."""

from types import SimpleNamespace

import pytest
from small_arms import planar_arm

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Sphere
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.planning.context import PlanningSettings
from armsim_ros.planning.scene.objects import AttachedObject, CollisionObject, ObjectShape
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import StartState


@pytest.mark.parametrize(('strict', 'left'), [(False, {'held'}), (True, set())])
def test_a_strict_start_state_drops_what_is_attached(strict, left):
    """Every service and action takes a state that is no difference as the parameter says."""
    scene = PlanningScene(KinematicModel(planar_arm()))
    scene.apply_attached(AttachedObject(
        'tool', CollisionObject('held', shapes=(ObjectShape(Sphere(0.1)),))))
    settings = PlanningSettings(strict_start_state=strict)
    context = SimpleNamespace(planner=SimpleNamespace(settings=settings))
    started = Context.started(context, scene, StartState(('axis1',), (0.1,), is_diff=False))
    assert set(started.attached) == left
