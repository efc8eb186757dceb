# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Objects around the robot."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from armsim_ros.config.world import WorldSettings
from armsim_ros.errors import SimulationError
from armsim_ros.model.geometry import Box, Sphere
from armsim_ros.model.robot_model import Inertial, LinkGeometry
from armsim_ros.model.semantic_model import SemanticModel
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.model.world_objects import prism, WorldObject
from armsim_ros.sim.physics.mujoco_model import Ground
from armsim_ros.sim.physics.robot_spec import untouching_pairs
from armsim_ros.sim.simulation import Simulation
from armsim_ros.sim.world.world_scene import OverlapError

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


def block(name, xyz, mass=None, height=0.1, friction=0.8):
    """Return a block of 0.1 m by 0.1 m."""
    return WorldObject(
        name, pose_matrix(xyz), (LinkGeometry(Box((0.1, 0.1, height)), np.eye(4)),), mass,
        friction,
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


@pytest.mark.parametrize('name', ['ball', 'shelf'])
def test_a_pose_is_read_as_it_was_set(crowded, name):
    """That of a free object and that of a fixed one, with their rotations."""
    pose = pose_matrix((0.0, 3.0, 1.0), (0.3, -0.5, 0.7))
    crowded.world.set_pose(name, pose)
    np.testing.assert_allclose(crowded.world.pose(name), pose, atol=1e-12)


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
    simulation.world.add(block('light', (0.4, 0.0, 0.2), mass=0.2, height=0.4, friction=0.2))
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
    ]


def test_without_an_srdf_no_links_of_the_robot_touch(arm):
    """Where nobody has said which pairs may overlap, a robot cannot jam in itself."""
    bodies = ('base', 'hand', 'lower', 'upper')
    assert untouching_pairs(replace(arm, srdf='')) == list(combinations(bodies, 2))


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


@pytest.mark.parametrize(('start', 'words'), [
    ({'shoulder': 2.4}, ('the floor and', "'tiny/hand'", 'raise the robot')),
    ({'shoulder': 2.8, 'elbow': 2.8}, ("'tiny/base'", "'tiny/lower'", 'disable the pair'))])
@pytest.mark.parametrize('named', [False, True])
def test_a_start_that_touches_names_the_pair(arm, settings, start, words, named):
    """Floor or link, whether joints or a named state say where the robot starts."""
    if named:
        full = {**dict.fromkeys(arm.active_joints, 0.0), **start}
        arm = replace(arm, semantic=SemanticModel(named_states={'arm': {'folded': full}}))
    settings = settings.model_copy(update={
        'initial_state': 'folded'} if named else {'initial_positions': start})
    warnings = [line for line in Simulation(arm, settings).warnings if 'at the start' in line]
    assert any(all(word in line for word in words) for line in warnings), warnings


def asleep(simulation):
    """Return the objects that the physics leaves alone."""
    model, data = simulation.mujoco_model, simulation.mujoco_data
    trees = {name: model.body_treeid[model.body(f'object/{name}').id]
             for name in simulation.world.names}
    return {name for name, tree in trees.items() if tree >= 0 and data.tree_asleep[tree] >= 0}


@pytest.fixture
def still(arm, settings, claim):
    """Return an arm and a shelf with a block and, beside it, a block, both asleep."""
    simulation = Simulation(arm, settings)
    claim(simulation, 'position')
    simulation.world.add(block('shelf', (2.0, 0.0, 0.5)))
    simulation.world.add(block('above', (2.0, 0.0, 0.601), mass=0.2))
    simulation.world.add(block('light', (0.4, 0.0, 0.2), mass=0.2, height=0.4, friction=0.2))
    run(simulation, 1500)
    assert asleep(simulation) == {'above', 'light'}
    return simulation


def test_a_touch_wakes_what_sleeps(still):
    """A block that lies still costs nothing, and is pushed away like any other."""
    for k in range(2000):
        still.command.position[:] = (min(1.5, 1e-3 * k), 0.0, 0.0)
        still.write()
        still.step()
    assert still.world.pose('light')[0, 3] > 0.5
    assert 'above' in asleep(still)


@pytest.mark.parametrize('taken', ['moved', 'removed'])
def test_what_sleeps_falls_when_its_support_goes(still, taken):
    """A sleeping block falls to the floor when the shelf below is moved or removed."""
    if taken == 'moved':
        still.world.set_pose('shelf', pose_matrix((5.0, 0.0, 0.5)))
    else:
        still.world.remove('shelf')
    run(still, 1500)
    assert still.world.pose('above')[2, 3] == pytest.approx(0.05, abs=2e-3)


def test_what_sleeps_wakes_where_it_is_put_and_at_a_push(still):
    """A sleeping block falls from where it is put; what comes from above wakes the other."""
    still.world.set_pose('light', pose_matrix((2.0, 0.0, 0.9)))
    run(still, 20)
    assert 'light' not in asleep(still)
    run(still, 2000)
    assert still.world.pose('light')[2, 3] < 0.86


def test_sleep_is_part_of_the_digest(arm, settings):
    """Two runs in which things fall asleep and wake are equal to the bit."""
    digests = []
    for _ in range(2):
        simulation = Simulation(arm, settings, WORLD)
        run(simulation, 2500)
        assert 'ball' in asleep(simulation)
        simulation.world.set_pose('ball', pose_matrix((2.0, 0.0, 0.5)))
        run(simulation, 700)
        digests.append(simulation.digest())
    assert digests[0] == digests[1]


def test_a_staged_change_is_made_later_and_moves_nothing(crowded):
    """Between staging and commit the old physics runs; the arm's state stays to the bit."""
    edit = crowded.world.stage(add=[block('late', (3.0, 0.0, 0.4), mass=1.0)], remove=['wedge'])
    run(crowded, 20)
    assert crowded.world.names == ('shelf', 'ball', 'wedge')
    data = crowded.mujoco_data
    before = [data.qpos[:3].copy(), data.qvel[:3].copy(), data.qacc_warmstart[:3].copy(),
              data.time, crowded.world.pose('ball')]
    crowded.world.commit(edit)
    data = crowded.mujoco_data
    after = [data.qpos[:3], data.qvel[:3], data.qacc_warmstart[:3], data.time,
             crowded.world.pose('ball')]
    for first, second in zip(before, after, strict=True):
        np.testing.assert_array_equal(first, second)
    assert crowded.world.names == ('shelf', 'ball', 'late')


def test_what_would_overlap_the_robot_is_undone(crowded):
    """A free object in a link is refused with the depth; a fixed one is not."""
    place = crowded.link_pose(next(iter(crowded.model.links)))[:3, 3]
    edit = crowded.world.stage(add=[block('inside', place, mass=0.1)])
    with pytest.raises(OverlapError, match=r"'inside' would overlap 'tiny/.*mm"):
        crowded.world.commit(edit, keep_clear=True)
    assert 'inside' not in crowded.world.names
    run(crowded, 5)
    crowded.world.commit(crowded.world.stage(add=[block('inside', place)]), keep_clear=True)
    assert 'inside' in crowded.world.names


@pytest.mark.parametrize(('height', 'words'), [(0.55, "'late' overlaps 'shelf' by 10.0 mm"),
                                              (0.5601, '')])
def test_what_a_new_object_overlaps_is_told(crowded, height, words):
    """It names the other object and the depth; what stands on something overlaps nothing."""
    place = crowded.world.pose('shelf')[:3, 3] + (0.0, 0.0, height)
    told = crowded.world.commit(
        crowded.world.stage(add=[block('late', place, mass=0.1)]), keep_clear=True)
    assert told == (words and f'{words}: they will be pushed apart')


def test_a_reset_brings_fixed_objects_back(crowded):
    """Whatever was put elsewhere stands where it first stood; free ones are at rest."""
    crowded.world.set_pose('shelf', pose_matrix((5.0, 0.0, 0.5)))
    crowded.world.set_pose('ball', pose_matrix((0.0, 3.0, 2.0)), (np.ones(3), np.ones(3)))
    np.testing.assert_allclose(crowded.world.twist('ball'), np.ones((2, 3)))
    crowded.reset()
    np.testing.assert_allclose(crowded.world.pose('shelf')[:3, 3], (1, 0, 0))
    np.testing.assert_allclose(crowded.world.pose('ball')[:3, 3], (1, 0, 0.7))
    np.testing.assert_array_equal(crowded.world.twist('ball'), np.zeros((2, 3)))


def test_a_whole_world_is_exchanged(crowded):
    """All objects and the floor go, others come, in one change."""
    world = crowded.world
    world.commit(world.stage(add=[block('ball', (0, 3, 0.4), mass=1.0)], remove=world.names,
                             ground=Ground(floor=None)))
    crowded.reset()
    assert (world.names, world.floor) == (('ball',), None)
    run(crowded, 500)
    assert world.pose('ball')[2, 3] < -0.5


def test_an_object_has_the_inertia_that_it_is_given(crowded):
    """Mass and centre come from the inertial, not from the shapes."""
    thing = replace(block('top', (4.0, 0.0, 1.0), mass=0.5), inertial=Inertial(
        0.5, pose_matrix((0, 0, 0.03)), np.diag([1e-3, 2e-3, 2.5e-3])))
    crowded.world.add(thing)
    body = crowded.mujoco_model.body('object/top')
    assert body.mass[0] == pytest.approx(0.5)
    np.testing.assert_allclose(body.ipos, (0, 0, 0.03))
    np.testing.assert_allclose(sorted(body.inertia), (1e-3, 2e-3, 2.5e-3))


@pytest.mark.parametrize(('share', 'height'), [(0.0, 5.0 - 0.5 * 9.81), (1.0, 5.0)])
def test_an_object_whose_weight_is_compensated_floats(crowded, share, height):
    """Without a touch it stays where it is."""
    crowded.world.add(replace(block('kite', (4.0, 0.0, 5.0), mass=0.5), gravcomp=share))
    run(crowded, 1000)
    assert crowded.world.pose('kite')[2, 3] == pytest.approx(height, abs=0.01)
