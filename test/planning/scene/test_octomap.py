# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Each occupied cell of an octomap is a box: no contact is lost, none invented."""

from dataclasses import replace
import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from small_arms import six_axis_arm

from armsim_ros.errors import PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.budget import CountingClock
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.collision.contacts import BodyType
from armsim_ros.planning.planner import MotionPlanner
from armsim_ros.planning.request import Constraints, MotionPlanRequest
from armsim_ros.planning.scene.objects import AttachedObject, CollisionObject, ObjectShape
from armsim_ros.planning.scene.octomap import Octomap, octomap_from_cells, OctomapUpdate
from armsim_ros.planning.scene.octree_data import Leaves, read_leaves, write_full
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import SceneUpdate

RESOLUTION = 0.03


def cells_map(keys, pose=None):
    """Return a pruned map of occupied cells, and free ones above them."""
    keys = np.unique(keys, axis=0)
    free = np.unique(keys + np.array([0, 0, 40]), axis=0)
    made = octomap_from_cells(
        np.vstack([keys, free]), np.repeat([1.0, -1.0], [len(keys), len(free)]).astype(np.float32),
        RESOLUTION, np.eye(4) if pose is None else pose)
    return replace(made, leaves=read_leaves(write_full(made.leaves), binary=False))


def scattered(seed, count=60):
    """Return cells in the arm's plane, among them full cubes that are pruned."""
    rng = np.random.default_rng(seed)
    cubes = np.stack(np.meshgrid(*[np.arange(4)] * 3), -1).reshape(-1, 3)
    keys = rng.integers([-30, -30, -2], [30, 30, 2], (count, 3))
    keys = np.vstack([keys, cubes + np.array([12, 4, 0]), cubes - np.array([16, 20, 4])])
    keys = keys[np.abs(keys[:, :2]).max(axis=1) > 4]
    return np.unique(keys, axis=0)


def as_boxes(octomap):
    """Return an object with a box for each cell."""
    centres, edges = octomap.boxes
    return CollisionObject('cells', pose=octomap.pose, shapes=tuple(
        ObjectShape(Box((edge,) * 3), pose_matrix(centre))
        for centre, edge in zip(centres, edges, strict=True)))


def checkers(kinematics, octomap, padding=0.0, load=None):
    """Return a checker of the map, and one of a box for each cell."""
    found = []
    for update in (SceneUpdate(octomap=OctomapUpdate(octomap)),
                   SceneUpdate(objects=(as_boxes(octomap),))):
        scene = PlanningScene(kinematics)
        scene.apply(replace(update, link_padding={'fore': padding}))
        if load is not None:
            scene.apply_attached(load)
        found.append(CollisionChecker(scene))
    return found


def nearest(pairs, name):
    """Return link -> distance [mm] to the nearest shape of an object; -1 where they touch."""
    found = {}
    for pair in pairs:
        if pair.names[1] == name:
            distance = round(1000 * pair.distance, 1) if pair.distance > 0 else -1
            found[pair.names[0]] = min(distance, found.get(pair.names[0], np.inf))
    return found


@pytest.mark.parametrize(('padding', 'clearance', 'turned', 'loaded'), [
    (0.0, 0.0, False, False), (0.01, 0.0, False, True), (0.0, 0.005, True, False)])
def test_states_are_those_of_a_box_for_each_cell(
    mesh_kinematics, padding, clearance, turned, loaded
):
    """Of a thousand states none has another answer, on shapes and hulls; meshes included."""
    pose = np.eye(4)
    if turned:
        pose[:3, :3] = Rotation.from_euler('xyz', [0.1, 0.2, 0.7]).as_matrix()
    load = AttachedObject('tool', CollisionObject(
        'load', shapes=(ObjectShape(Box((0.1, 0.1, 0.1))),)), ('tool', 'fore', 'finger'))
    ours, boxes = checkers(
        mesh_kinematics, cells_map(scattered(3), pose), padding, load if loaded else None)
    rng = np.random.default_rng(0)
    states = rng.uniform(-3, 3, (334, mesh_kinematics.n))
    # Links along the axes of the map are parallel to the faces of its cells.
    states[::3] = rng.integers(-2, 3, states[::3].shape) * np.pi / 4
    answers = {True: [], False: []}
    for exact in (True, False):
        for q in states:
            mine = ours.in_collision(q, None, clearance, exact)
            assert mine == boxes.in_collision(q, None, clearance, exact), q
            answers[exact].append(mine)
    assert 50 < sum(answers[True]) < 330
    reach = rng.uniform(0, 0.05, states.shape)
    assert (ours.near_pairs(states[:150], reach[:150]).motions
            == boxes.near_pairs(states[:150], reach[:150]).motions).all()


def test_distances_are_those_of_a_box_for_each_cell(mesh_kinematics):
    """What servo slows down by is the distance to the nearest cell."""
    ours, boxes = checkers(mesh_kinematics, cells_map(scattered(5)))
    rng = np.random.default_rng(1)
    for q in rng.uniform(-3, 3, (60, mesh_kinematics.n)):
        mine, theirs = ours.distance(q), boxes.distance(q)
        assert (mine > 0) == (theirs > 0)
        if mine > 0:
            assert mine == pytest.approx(theirs, abs=1e-5)
        near = nearest(ours.pair_distances(q, 0.05), '<octomap>')
        assert near == nearest(boxes.pair_distances(q, 0.05), 'cells')


def test_contact_names_the_octomap(kinematics):
    """It counts as an object of the world."""
    scene = PlanningScene(kinematics)
    scene.set_octomap(cells_map([(20, 0, 0)]))
    contact, = CollisionChecker(scene).contacts(np.zeros(kinematics.n))
    assert (contact.body2, contact.type2) == ('<octomap>', BodyType.WORLD_OBJECT)
    assert contact.body1 == 'fore'
    assert contact.depth > 0.0


def test_allowed_collision_matrix_knows_its_name(kinematics):
    """A pair and a default entry let it be touched."""
    scene = PlanningScene(kinematics)
    scene.set_octomap(cells_map([(20, 0, 0)]))
    checker, q = CollisionChecker(scene), np.zeros(kinematics.n)
    assert checker.in_collision(q)
    rules = scene.acm
    scene.set_acm(rules.with_pair('fore', '<octomap>', True))
    assert not checker.in_collision(q)
    scene.set_acm(rules.with_default('<octomap>', True))
    assert not checker.in_collision(q)
    scene.set_acm(rules)
    assert checker.in_collision(q)


def test_checker_follows_the_map(kinematics):
    """A replaced map and one that is gone count at once; a snapshot keeps what it had."""
    scene = PlanningScene(kinematics)
    checker, q = CollisionChecker(scene), np.zeros(kinematics.n)
    assert not checker.in_collision(q)
    scene.set_octomap(cells_map([(20, 0, 0)]))
    before = scene.snapshot()
    assert checker.in_collision(q)
    scene.set_octomap(cells_map([(20, 20, 0)]))
    assert not checker.in_collision(q)
    assert not scene.content.collides_like(before.content)
    scene.set_octomap(None)
    assert not checker.in_collision(q)
    assert CollisionChecker(before).in_collision(q)


def test_map_is_placed_in_its_frame(kinematics):
    """The frame of an update is one of the scene; an unknown one changes nothing."""
    scene = PlanningScene(kinematics)
    octomap = cells_map([(0, 0, 0)], pose_matrix((0.05, 0, 0)))
    scene.apply(SceneUpdate(octomap=OctomapUpdate(octomap, 'finger')))
    assert np.allclose(scene.octomap.pose[:3, 3], [0.85, 0, 0])
    kept = scene.octomap
    with pytest.raises(PlanningError, match='nowhere'):
        scene.apply(SceneUpdate(octomap=OctomapUpdate(octomap, 'nowhere')))
    assert scene.octomap is kept
    scene.apply(SceneUpdate(objects=()))
    assert scene.octomap is kept
    scene.apply(SceneUpdate(octomap=OctomapUpdate()))
    assert scene.octomap is None


def test_largest_leaf_is_all_space(kinematics):
    """A root without children is one leaf, and the arm is in it."""
    scene = PlanningScene(kinematics)
    scene.set_octomap(Octomap(0.1, Leaves(
        np.zeros((1, 3), dtype=np.int64), np.array([16]), np.ones(1, dtype=np.float32))))
    assert CollisionChecker(scene).in_collision(np.zeros(kinematics.n))


@pytest.mark.parametrize('seed', range(6))
def test_no_plan_passes_a_cell(seed):
    """Each state of a motion through clutter is free of all cells, by boxes."""
    rng = np.random.default_rng(seed)
    model = KinematicModel(six_axis_arm())
    octomap = cells_map(rng.integers([-24, -24, 4], [24, 24, 30], (60, 3)))
    scene, boxes = PlanningScene(model), PlanningScene(model)
    scene.set_octomap(octomap)
    boxes.apply_object(as_boxes(octomap))
    checker, planner = CollisionChecker(boxes), MotionPlanner(scene)
    free = [q for q in rng.uniform(-2, 2, (40, model.n)) if not checker.in_collision(q)]
    planned = 0
    for start, goal in list(zip(free[::2], free[1::2], strict=False))[:3]:
        scene.set_state(start)
        response = planner.plan(MotionPlanRequest(
            group_name='arm', goal_constraints=(Constraints.of_joints(model.positions(goal)),),
            allowed_planning_time=0.2, seed=seed), scene.snapshot(), clock=CountingClock())
        if response.success:
            planned += 1
            points = response.trajectory.positions
            dense = np.vstack([a + (b - a) * t for a, b in itertools.pairwise(points)
                               for t in (0.0, 0.5)] + [points[-1:]])
            full = [model.vector(dict(zip(response.trajectory.joint_names, q, strict=True)))
                    for q in dense]
            assert not any(checker.in_collision(q) for q in full)
    assert planned
