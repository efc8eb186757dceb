# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Objects around the robot."""

from dataclasses import replace

import numpy as np
import pytest

from armsim_ros.config.world import WorldSettings
from armsim_ros.errors import SimulationError
from armsim_ros.model.geometry import Box, Sphere
from armsim_ros.model.robot_model import LinkGeometry, SemanticModel
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.model.world_objects import prism, WorldObject
from armsim_ros.sim.robot_spec import untouching_pairs
from armsim_ros.sim.simulation import Simulation

WORLD = WorldSettings.model_validate(
    {
        'objects': {
            'shelf': {
                'xyz': [1.0, 0.0, 0.0],
                'parts': [
                    {'shape': {'type': 'box', 'size': [0.4, 0.4, 0.02]}, 'xyz': [0, 0, 0.5]}
                ],
            },
            'ball': {
                'xyz': [1.0, 0.0, 0.7],
                'mass': 0.2,
                'parts': [{'shape': {'type': 'sphere', 'radius': 0.05}}],
            },
            'wedge': {
                'xyz': [2.0, 0.0, 0.05],
                'mass': 0.3,
                'parts': [
                    {
                        'shape': {
                            'type': 'prism',
                            'corners': [[0, 0], [0.1, 0], [0, 0.1]],
                            'length': 0.04,
                        }
                    },
                    {
                        'shape': {'type': 'cone', 'radius': 0.02, 'length': 0.04},
                        'xyz': [0, 0, 0.04],
                    },
                    {'shape': {'type': 'capsule', 'radius': 0.01, 'length': 0.02}},
                    {'shape': {'type': 'cylinder', 'radius': 0.01, 'length': 0.02}},
                ],
            },
        }
    }
)


def block(name, xyz, mass=None, height=0.1):
    """Return a block of 0.1 m by 0.1 m."""
    return WorldObject(
        name, pose_matrix(xyz), (LinkGeometry(Box((0.1, 0.1, height)), np.eye(4)),), mass
    )


@pytest.fixture
def crowded(arm, settings):
    """Return the arm in a world with a shelf, a ball above it and a wedge."""
    return Simulation(arm, settings, WORLD)


def run(simulation, steps):
    """Step on."""
    for _ in range(steps):
        simulation.step()


def test_things_fall_onto_things(crowded):
    """A ball comes to rest on a fixed shelf; the shelf stays."""
    run(crowded, 1500)
    assert crowded.world.names == ('shelf', 'ball', 'wedge')
    assert crowded.world.pose('ball')[2, 3] == pytest.approx(0.56, abs=1e-3)
    np.testing.assert_allclose(crowded.world.pose('shelf')[:3, 3], (1, 0, 0))
    assert 0.0 < crowded.world.pose('wedge')[2, 3] < 0.05


def test_objects_come_and_go_without_disturbing_the_rest(crowded, claim):
    """Adding and removing objects at run time keeps robot and other objects as they are."""
    claim(crowded, 'position')
    crowded.command.position[:] = 0.3
    for _ in range(700):
        crowded.write()
        crowded.step()
    before = crowded.state.position.copy(), crowded.world.pose('ball')
    crowded.world.add(block('late', (3.0, 0.0, 0.4), mass=1.0))
    crowded.world.remove('wedge')
    assert crowded.world.names == ('shelf', 'ball', 'late')
    np.testing.assert_array_equal(crowded.state.position, before[0])
    np.testing.assert_array_equal(crowded.world.pose('ball'), before[1])
    run(crowded, 1000)
    np.testing.assert_allclose(crowded.state.position, 0.3, atol=1e-4)
    assert crowded.world.pose('late')[2, 3] == pytest.approx(0.05, abs=2e-3)
    crowded.reset()
    assert crowded.world.pose('late')[2, 3] == pytest.approx(0.4)


def test_names_are_unique_and_known(crowded):
    """A second object of a name and an unknown name are refused; the world stays."""
    with pytest.raises(SimulationError, match="already has an object 'ball'"):
        crowded.world.add(block('ball', (0, 0, 1)))
    with pytest.raises(SimulationError, match=r"no object 'bal'.*'ball'"):
        crowded.world.remove('bal')
    assert crowded.world.names == ('shelf', 'ball', 'wedge')
    run(crowded, 10)


def test_an_object_that_physics_refuses_leaves_the_world_as_it_was(crowded):
    """An impossible shape is refused with a message and the world goes on."""
    flat = WorldObject('flat', np.eye(4), (LinkGeometry(Sphere(-1.0), np.eye(4)),))
    with pytest.raises(SimulationError):
        crowded.world.add(flat)
    assert 'flat' not in crowded.world.names
    run(crowded, 10)
    crowded.world.add(block('fine', (0.0, 3.0, 0.5)))
    run(crowded, 10)


def test_objects_can_be_put_elsewhere(crowded):
    """An object that is put elsewhere is there, at rest; a fixed one is in the way there."""
    crowded.world.set_pose('ball', pose_matrix((0.0, 3.0, 1.0)))
    crowded.world.set_pose('shelf', pose_matrix((0.0, 3.0, 0.0)))
    run(crowded, 1500)
    np.testing.assert_allclose(crowded.world.pose('ball')[:3, 3], (0.0, 3.0, 0.56), atol=2e-3)


def test_a_thing_in_the_way_stops_the_arm(arm, settings, claim):
    """A fixed block stops the arm: it pushes with no more than its effort and stays outside."""
    simulation = Simulation(arm, settings)
    claim(simulation, 'position')
    simulation.world.add(block('wall', (0.35, 0.0, 0.4)))
    for k in range(1500):
        simulation.command.position[:] = (min(1.2, 1e-3 * k), 0.0, 0.0)
        simulation.write()
        simulation.step()
    assert simulation.state.position[0] < 0.9
    assert np.abs(simulation.state.effort).max() <= 30.0
    simulation.world.remove('wall')
    for _ in range(1000):
        simulation.write()
        simulation.step()
    assert simulation.state.position[0] == pytest.approx(1.2, abs=1e-3)


def test_the_arm_pushes_things_away(arm, settings, claim):
    """A light block is moved by the arm, which then reaches its goal."""
    simulation = Simulation(arm, settings)
    claim(simulation, 'position')
    simulation.world.add(block('light', (0.4, 0.0, 0.2), mass=0.2, height=0.4))
    for k in range(2000):
        simulation.command.position[:] = (min(1.5, 1e-3 * k), 0.0, 0.0)
        simulation.write()
        simulation.step()
    assert simulation.world.pose('light')[0, 3] > 0.5
    assert simulation.state.position[0] == pytest.approx(1.5, abs=0.01)


@pytest.mark.parametrize(
    'corners', [[(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 0), (0, 1), (1, 1), (1, 0)]]
)
def test_a_prism_has_its_volume_in_either_sense(corners):
    """Corners may run either way: the faces look outwards, the volume is positive."""
    mesh = prism(corners, 0.5)
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
    assert np.einsum('ij,ij->i', a, np.cross(b, c)).sum() / 6.0 == pytest.approx(0.5)


def test_a_prism_must_be_convex():
    """A polygon with a notch is refused with the way out."""
    with pytest.raises(SimulationError, match='convex'):
        prism([(0, 0), (1, 0), (0.2, 0.2), (0, 1)], 0.1)


def test_neighbours_and_disabled_pairs_do_not_touch(arm):
    """Links that the SRDF disables, and neighbours, pass through each other."""
    semantic = SemanticModel(disabled_collisions={('hand', 'upper'): 'Never'})
    arm = replace(arm, semantic=semantic)
    assert untouching_pairs(arm) == [
        ('base', 'upper'), ('hand', 'lower'), ('hand', 'upper'), ('lower', 'upper'),
    ]  # fmt: skip


def test_says_what_overlaps_at_the_start(arm, settings):
    """A robot that starts inside an object gets a warning with both names and the depth."""
    world = WorldSettings.model_validate(
        {
            'objects': {
                'crate': {
                    'xyz': [0, 0, 0.5],
                    'parts': [{'shape': {'type': 'box', 'size': [0.3, 0.3, 0.1]}}],
                }
            }
        }
    )
    warning = Simulation(arm, settings, world).warnings[0]
    assert 'tiny/' in warning
    assert 'object/crate' in warning
    assert Simulation(arm, settings).warnings == ()
