# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The planner of ArmSim sees the simulated world by itself, and leaves the user's own alone."""

import numpy as np
import pytest

from armsim_ros import ArmSim, Box, pose_matrix, WorldObject
from armsim_ros.errors import PlanningError
from armsim_ros.planning.scene.objects import CollisionObject, ObjectOperation, ObjectShape

STATE = 'scan_food'


def block(name, xyz, mass=None):
    """Return a cube of 10 cm."""
    return WorldObject.of_shape(name, Box((0.1, 0.1, 0.1)), pose_matrix(xyz), mass=mass)


@pytest.fixture
def sim():
    """Return the default arm at the feeding place."""
    return ArmSim()


def test_objects_of_the_world_are_known_where_they_are(sim):
    """All of them, and the floor; what has moved is where it is now."""
    sim.plan(STATE)
    world = sim.simulation.world
    assert set(sim.scene.objects) == {*world.names, 'floor'}
    world.set_pose('cube', pose_matrix((0.3, -0.2, 1.2)))
    sim.plan(STATE)
    np.testing.assert_allclose(sim.scene.objects['cube'].pose[:3, 3], (0.3, -0.2, 1.2), atol=1e-9)
    world.remove('cube')
    sim.plan(STATE)
    assert 'cube' not in sim.scene.objects


def test_a_plan_does_not_go_through_the_world(sim):
    """What stands where the arm would be at the goal is in the way, until it is gone."""
    sim.plan(STATE)
    tip = sim.scene.kinematic_model.link_pose(
        sim.scene.kinematic_model.vector(sim.model.semantic.named_states['manipulator'][STATE]),
        'link_6')
    sim.simulation.world.add(block('wall', tip[:3, 3]))
    with pytest.raises(PlanningError, match='wall'):
        sim.plan(STATE)
    sim.simulation.world.remove('wall')
    sim.plan(STATE)


def test_what_the_user_changes_is_his(sim):
    """Removed it stays away, added it is his own; deleted in the world it is the world's again."""
    sim.plan(STATE)
    sim.scene.apply_object(CollisionObject('cube', ObjectOperation.REMOVE))
    sim.scene.apply_object(CollisionObject(
        'star', pose=pose_matrix((2.0, 0.0, 1.0)), shapes=(ObjectShape(Box((0.1, 0.1, 0.1))),)))
    sim.simulation.world.set_pose('star', pose_matrix((0.3, -0.2, 1.2)))
    sim.plan(STATE)
    assert 'cube' not in sim.scene.objects
    np.testing.assert_allclose(sim.scene.objects['star'].pose[:3, 3], (2.0, 0.0, 1.0))
    sim.remove_object('cube')
    sim.add_object(block('cube', (0.3, -0.2, 1.2), mass=0.1))
    assert 'cube' in sim.scene.objects


def test_the_switch_leaves_what_was_added():
    """``scene_from_world`` false: planning knows what ``add_object`` was told alone."""
    sim = ArmSim(overrides={'planning_parameters.scene_from_world': 'false'})
    sim.add_object(block('mine', (2.0, 0.0, 1.0)))
    sim.plan(STATE)
    assert set(sim.scene.objects) == {'mine'}
