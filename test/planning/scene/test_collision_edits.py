# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Edits of a scene as the collision checker follows them."""

from collision_truth import states, thing, truth
from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np

from armsim_ros.errors import PlanningError
from armsim_ros.model.geometry import Box, Cylinder, Plane, Sphere
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.scene.objects import (
    AttachedObject,
    CollisionObject,
    ObjectOperation,
    ObjectShape,
)
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import SceneUpdate

ADD, REMOVE, APPEND, MOVE = ObjectOperation


SHAPES = st.one_of(
    st.tuples(*[st.floats(0.05, 0.3)] * 3).map(Box),
    st.floats(0.03, 0.15).map(Sphere),
    st.builds(Cylinder, st.floats(0.03, 0.1), st.floats(0.05, 0.3)),
    st.builds(Plane, st.floats(0.1, 1), st.floats(0.1, 1), st.just(0.0), st.floats(0.6, 1.0)),
)
PLACES = st.tuples(st.floats(-0.8, 0.8), st.floats(-0.8, 0.8), st.floats(-0.1, 0.1))
IDS = st.sampled_from(['a', 'b', 'c', 'd', 'fore'])
LINKS = st.sampled_from(['fore', 'finger', 'tool'])
BODIES = st.sampled_from(['base', 'upper', 'fore', 'finger', 'a', 'b', 'c'])
EDITS = st.one_of(
    st.builds(lambda i, g, p: ('object', thing(i, g, p)), IDS, SHAPES, PLACES),
    st.builds(lambda i, p: ('object', CollisionObject(i, MOVE, pose=pose_matrix(p))),
              IDS, PLACES),
    st.builds(lambda i, g, p: ('object', thing(i, g, p, operation=APPEND)), IDS, SHAPES, PLACES),
    st.builds(lambda i: ('object', CollisionObject(i, REMOVE)), IDS),
    st.builds(lambda i, link, t: ('attached', AttachedObject(
        link, CollisionObject(i), tuple(t))), IDS, LINKS, st.lists(BODIES, max_size=2)),
    st.builds(lambda i: ('attached', AttachedObject('', CollisionObject(i, REMOVE))),
              IDS),
    st.builds(lambda a, b, v: ('acm', (a, b, v)), BODIES, BODIES, st.booleans()),
    st.builds(lambda link, v: ('padding', {link: v}), st.sampled_from(['upper', 'fore']),
              st.sampled_from([0.0, 0.03])),
    st.builds(lambda link, v: ('scale', {link: v}), st.sampled_from(['upper', 'fore']),
              st.sampled_from([1.0, 1.2])),
    st.builds(lambda v: ('state', v), st.floats(-1, 1)),
    st.builds(lambda g: ('ask', g), st.sampled_from([None, 'arm', 'hand'])),
)


def apply_edit(scene, checker, kind, what):
    """Apply an edit, or ask something in between; a refused edit is none."""
    try:
        if kind == 'object':
            scene.apply_object(what)
        elif kind == 'attached':
            scene.apply_attached(what)
        elif kind == 'acm' and what[0] != what[1]:
            scene.set_acm(scene.acm.with_pair(*what))
        elif kind == 'padding':
            scene.apply(SceneUpdate(link_padding=what))
        elif kind == 'scale':
            scene.apply(SceneUpdate(link_scale=what))
        elif kind == 'state':
            scene.set_positions({'shoulder': what})
        elif kind == 'ask':
            checker.in_collision(scene.q, what)
    except PlanningError:
        pass


@settings(max_examples=120, deadline=None)
@given(edits=st.lists(EDITS, max_size=25))
def test_followed_edits_equal_a_new_checker(mesh_kinematics, edits):
    """After any edits the answers are those of a new checker, and the truth."""
    scene = PlanningScene(mesh_kinematics)
    checker = CollisionChecker(scene)
    for item in edits:
        apply_edit(scene, checker, *item)
    fresh = CollisionChecker(scene)
    for q in states(scene, 12, seed=len(edits)):
        for group in (None, 'arm', 'hand'):
            assert checker.in_collision(q, group) == fresh.in_collision(q, group)
            assert (checker.in_collision(q, group, exact=False)
                    == fresh.in_collision(q, group, exact=False))
        if not any(scene.link_padding.values()) and set(scene.link_scale.values()) == {1.0}:
            assert checker.in_collision(q) == bool(truth(scene, q))
        assert checker.displacement_bound(scene.q, q) == fresh.displacement_bound(scene.q, q)
        names = [
            sorted((c.body1, c.body2) for c in one.contacts(q)) for one in (checker, fresh)
        ]
        assert {tuple(sorted(p)) for p in names[0]} == {tuple(sorted(p)) for p in names[1]}


def test_use_switches_between_scenes(scene):
    """One checker serves the scene and its overlays in turn."""
    checker = CollisionChecker(scene)
    overlay = scene.with_update(SceneUpdate(objects=(
        thing('box', Box((0.1, 0.1, 0.1)), (0.6, 0, 0)),)))
    for _ in range(3):
        assert not checker.in_collision(scene.q)
        checker.use(overlay)
        assert checker.in_collision(scene.q)
        checker.use(scene)


def test_many_edits_do_not_pile_up(scene):
    """Objects that went are forgotten."""
    checker = CollisionChecker(scene)
    for number in range(50):
        scene.apply_object(thing('box', Box((0.1, 0.1, 0.1 + number * 1e-4)), (0.6, 0, 0)))
        assert checker.in_collision(scene.q)
    (tables,) = checker._tables.tables
    assert len(tables.shapes) == 5


def crowd(count):
    """Return the update that adds boxes far from the robot."""
    return SceneUpdate(objects=tuple(
        thing(f'far {k}', Box((0.1, 0.1, 0.1)), (5.0 + k % 20, k // 20, 0)) for k in range(count)
    ))


def test_a_scene_of_many_objects_is_held_in_several_tables(scene):
    """Every object counts, wherever it is held; what goes makes room again."""
    scene.apply(crowd(350))
    checker = CollisionChecker(scene)
    assert len(checker._tables.tables) == 4
    reach = np.full((1, len(scene.q)), 0.01)
    assert not checker.in_collision(scene.q)
    assert not checker.near_pairs(scene.q[None], reach).motions[0]
    for k in (3, 177, 349):
        scene.apply_object(CollisionObject(f'far {k}', MOVE, pose=pose_matrix((0.6, 0, 0))))
        assert checker.in_collision(scene.q)
        assert checker.near_pairs(scene.q[None], reach).motions[0]
        assert {contact.body2 for contact in checker.contacts(scene.q)} == {f'far {k}'}
        assert checker.distance(scene.q) < 0.0
        scene.set_acm(scene.acm.with_entry(f'far {k}', True, ('upper', 'fore', 'finger', 'base')))
        assert not checker.in_collision(scene.q)
    scene.apply_object(CollisionObject('', REMOVE))
    assert not checker.in_collision(scene.q)
    assert len(checker._tables.tables) == 1
    scene.apply_object(thing('near', Box((0.1, 0.1, 0.1)), (0.6, 0, 0)))
    assert checker.in_collision(scene.q)


def test_what_is_carried_meets_every_table(scene):
    """An attached object and padded links are checked against all objects."""
    scene.apply(crowd(250))
    checker = CollisionChecker(scene)
    assert not checker.in_collision(scene.q)
    scene.apply(SceneUpdate(link_padding={'fore': 6.0}))
    assert checker.in_collision(scene.q)
    scene.apply(SceneUpdate(link_padding={'fore': 0.0}))
    assert not checker.in_collision(scene.q)
    long = CollisionObject(
        'pole', frame_id='fore',
        shapes=(ObjectShape(Box((0.01, 40.0, 0.01)), pose_matrix((4.6, 0, 0))),))
    scene.apply_attached(AttachedObject('fore', long, ('upper', 'fore', 'finger', 'base')))
    touched = {contact.body2 for contact in checker.contacts(scene.q)}
    assert {'far 0', 'far 20', 'far 240'} <= touched
