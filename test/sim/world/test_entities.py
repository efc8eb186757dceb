# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Entities of a simulation: which come, go, and are there again after a reset."""

import mujoco
import numpy as np
import pytest

from armsim_ros.config.world import WorldSettings
from armsim_ros.errors import SimulationError
from armsim_ros.model.geometry import Sphere
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.sim.physics.mujoco_model import Ground
from armsim_ros.sim.simulation import Simulation
from armsim_ros.sim.world.entities import Category, Entities, EntityInfo, EntityState, RobotEntity

WORLD = WorldSettings.model_validate({'objects': {
    name: {'xyz': [x, 0.0, 0.5], 'mass': 0.2, 'parts': [
        {'shape': {'type': 'sphere', 'radius': 0.05}}]}
    for name, x in (('ball', 1.0), ('marble', 2.0))}})


def ball(name, xyz=(0.0, 3.0, 0.5)):
    """Return a free object."""
    return WorldObject.of_shape(name, Sphere(0.05), pose_matrix(xyz), mass=0.1)


@pytest.fixture
def simulation(arm, settings):
    """Give an arm and two balls."""
    return Simulation(arm, settings, WORLD)


@pytest.fixture
def entities(arm, simulation):
    """Give the entities of the simulation."""
    return Entities(simulation, [RobotEntity('tiny', arm.root_link, tuple(arm.links))])


def reset(entities, *, whole):
    """Reset what there is."""
    edit = entities.stage_reset(whole=whole)
    if edit is not None:
        entities.commit(edit)


def delete(entities, name):
    """Delete an object."""
    entities.commit(entities.stage_delete([name]))


def test_a_whole_reset_brings_deleted_objects_back(entities):
    """As if launched again. simulation_interfaces ResetSimulation.srv, SCOPE_ALL."""
    delete(entities, 'ball')
    entities.spawn(entities.stage_spawn([ball('new')]))
    reset(entities, whole=True)
    assert entities.names == ('ball', 'marble', 'tiny')
    assert entities.state('ball').pose[:3, 3] == pytest.approx((1.0, 0.0, 0.5))
    assert entities.spawned == ()
    assert entities.stage_reset(whole=True) is None


def test_a_whole_reset_is_the_same_start(entities, simulation):
    """The state is the same to the bit, whatever was deleted."""
    simulation.reset()
    before = simulation.digest()
    delete(entities, 'ball')
    reset(entities, whole=True)
    simulation.reset()
    assert simulation.digest() == before


def test_an_object_of_a_deleted_objects_name_is_replaced(entities, simulation):
    """The object of the loaded world returns in its place."""
    loaded = simulation.world.objects['ball']
    delete(entities, 'ball')
    entities.spawn(entities.stage_spawn([ball('ball')]))
    assert entities.spawned == ('ball',)
    reset(entities, whole=True)
    assert simulation.world.objects['ball'] is loaded


def test_a_reset_of_what_was_spawned_leaves_deleted_objects_out(entities):
    """simulation_interfaces ResetSimulation.srv, SCOPE_SPAWNED."""
    delete(entities, 'ball')
    entities.spawn(entities.stage_spawn([ball('ball'), ball('new', (0.0, 4.0, 0.5))]))
    reset(entities, whole=False)
    assert entities.names == ('marble', 'tiny')


def test_the_loaded_world_is_what_returns(entities):
    """After another world was loaded its objects come back, not those of the first."""
    entities.load(entities.stage_load([ball('first'), ball('second', (0.0, 4.0, 0.5))], Ground()))
    assert entities.spawned == ()
    delete(entities, 'first')
    reset(entities, whole=True)
    assert entities.names == ('first', 'second', 'tiny')


def test_infos_can_be_forgotten(entities):
    """Description and labels are those of the start then."""
    before = entities.info('ball')
    entities.set_info('ball', EntityInfo(Category.HUMAN, 'red', ('food',)))
    assert entities.info('ball') == EntityInfo(Category.HUMAN, 'red', ('food',))
    entities.forget_infos()
    assert entities.info('ball') == before


@pytest.mark.parametrize(('requested', 'name'), [
    ('tiny', 'tiny_1'), ('tiny/hand', 'tiny/hand_1'), ('ball', 'ball_1'), ('new', 'new'),
    ('floor', 'floor_1'),
])
def test_a_free_name_is_that_of_nothing_else(entities, requested, name):
    """Robots, their links, objects and what is reserved. SpawnEntity.srv, allow_renaming."""
    assert entities.free_name(requested, ['floor']) == name


def test_a_fixed_object_has_no_acceleration(entities):
    """It is refused for it, and not used for others. SetEntityState.srv, state."""
    moving = EntityState(pose_matrix((4.0, 0.0, 0.5)), angular_acceleration=np.array([0, 0, 1.0]))
    wall = WorldObject.of_shape('wall', Sphere(0.05), pose_matrix((0.0, 3.0, 0.5)))
    entities.spawn(entities.stage_spawn([wall]))
    with pytest.raises(SimulationError, match="'wall' is fixed and cannot have an acceleration"):
        entities.set_state('wall', moving)
    entities.set_state('ball', moving)
    assert entities.state('ball').pose[0, 3] == 4.0


def test_the_acceleration_of_an_object(entities, simulation):
    """That of gravity while it falls, 0 once it rests. EntityState.msg, acceleration."""
    simulation.step()
    falling, gravity = entities.state('ball'), simulation.mujoco_model.opt.gravity
    np.testing.assert_allclose(falling.linear_acceleration, gravity, atol=1e-6)
    for _ in range(4000):
        simulation.step()
    resting = entities.state('ball')
    np.testing.assert_allclose(resting.linear_acceleration, 0.0, atol=1e-3)


def mujoco_acceleration(simulation, body):
    """Return what MuJoCo's accelerometers measure, but for gravity: (3,) and (3,)."""
    model, data, found = simulation.mujoco_model, simulation.mujoco_data, np.empty(6)
    mujoco.mj_rnePostConstraint(model, data)
    mujoco.mj_objectAcceleration(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, found, 0)
    return found[3:] + model.opt.gravity, found[:3]


def test_the_acceleration_of_a_link(entities, simulation):
    """As an accelerometer of MuJoCo has it; 0 at the start, where nothing has acted."""
    hand = entities.state('tiny/hand')
    np.testing.assert_array_equal(hand.linear_acceleration, 0.0)
    simulation.apply_wrench('hand', force=(5.0, 3.0, 0.0))
    for _ in range(20):
        simulation.step()
    hand = entities.state('tiny/hand')
    linear, angular = mujoco_acceleration(simulation, simulation.link_body('hand'))
    assert np.linalg.norm(linear) > 0.1
    np.testing.assert_allclose(hand.linear_acceleration, linear, atol=1e-9)
    np.testing.assert_allclose(hand.angular_acceleration, angular, atol=1e-9)
