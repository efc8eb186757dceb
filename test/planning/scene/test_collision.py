# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Collision checks: truth, rules, and edits that are followed."""

import math

from collision_truth import clutter, states, thing, truth
import numpy as np
import pytest

from armsim_ros.errors import PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Box, Cylinder, Mesh, Plane, Sphere
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.collision.contacts import BodyType
from armsim_ros.planning.scene.objects import (
    AttachedObject,
    CollisionObject,
    ObjectOperation,
    ObjectShape,
)
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import SceneUpdate

ADD, REMOVE, APPEND, MOVE = ObjectOperation


@pytest.mark.parametrize('kind', ['kinematics', 'mesh_kinematics'])
def test_answers_equal_brute_force(kind, request, make_mesh):
    """Of 400 states each answer and each pair is that of plain checks of all shapes."""
    scene = PlanningScene(request.getfixturevalue(kind))
    clutter(scene, make_mesh)
    checker = CollisionChecker(scene)
    hits = 0
    for q in states(scene, 400):
        expected = truth(scene, q)
        hits += bool(expected)
        assert checker.in_collision(q) == bool(expected)
        contacts = checker.contacts(q)
        assert {tuple(sorted((c.body1, c.body2))) for c in contacts} == expected
        assert checker.in_collision(q, exact=False) or not expected
        assert (checker.distance(q) <= 1e-6) == bool(expected)
    assert 40 < hits < 360


def test_self_collision_is_found_and_the_default_state_is_free(scene):
    """SRV-22: folded onto itself the arm touches its base."""
    checker = CollisionChecker(scene)
    assert checker.contacts(scene.q) == []
    folded = scene.kinematic_model.vector({'elbow': 3.05})
    names = {(c.body1, c.body2) for c in checker.contacts(folded)}
    assert names == {('base', 'finger')}


def test_contact_has_place_normal_and_depth(scene):
    """SRV-21: body names and types, a point between them, the way out, the overlap."""
    scene.apply_object(thing('ball', Sphere(0.1), (0.6, 0.115, 0.0)))
    contact, = CollisionChecker(scene).contacts(scene.q)
    assert (contact.body1, contact.type1) == ('fore', BodyType.ROBOT_LINK)
    assert (contact.body2, contact.type2) == ('ball', BodyType.WORLD_OBJECT)
    assert contact.depth == pytest.approx(0.01, abs=1e-6)
    np.testing.assert_allclose(contact.position, (0.6, 0.02, 0.0), atol=6e-3)
    np.testing.assert_allclose(contact.normal, (0, 1, 0), atol=1e-6)
    assert str(contact) == "link 'fore' touches object 'ball' (overlap 10 mm)"


def test_contacts_are_one_a_pair_deepest_first_and_limited(scene):
    """SRV-21: two shapes of one object are one contact."""
    scene.apply_object(CollisionObject(
        'pair',
        shapes=(
            ObjectShape(Sphere(0.1), pose_matrix((0.5, 0.12, 0))),
            ObjectShape(Sphere(0.1), pose_matrix((0.6, 0.11, 0))))))
    scene.apply_object(thing('deep', Box((0.1, 0.1, 0.1)), (0.2, 0, 0)))
    checker = CollisionChecker(scene)
    found = checker.contacts(scene.q)
    assert [contact.body2 for contact in found] == ['deep', 'pair']
    assert found[1].depth == pytest.approx(0.015, abs=1e-6)
    assert len(checker.contacts(scene.q, max_contacts=1)) == 1


def test_distance_is_that_of_the_nearest_pair(scene):
    """The free way in metres; infinite where nothing is checked."""
    checker = CollisionChecker(scene)
    scene.apply_object(thing('ball', Sphere(0.1), (0.6, 0.225, 0.0)))
    assert checker.distance(scene.q, 'arm') == pytest.approx(0.1, abs=1e-6)
    scene.apply_object(CollisionObject('', REMOVE))
    scene.set_acm(scene.acm.with_default('finger', True))
    assert checker.distance(scene.q, 'hand') == math.inf


def test_allowed_pairs_are_not_checked(scene):
    """SCN-13: an allowed object may be touched by that link and by no other."""
    checker = CollisionChecker(scene)
    scene.apply_object(thing('box', Box((0.1, 0.1, 0.1)), (0.6, 0, 0)))
    scene.set_acm(scene.acm.with_pair('box', 'fore', True))
    assert not checker.in_collision(scene.q)
    scene.set_acm(scene.acm.with_pair('box', 'fore', False))
    assert checker.in_collision(scene.q)
    scene.set_acm(scene.acm.with_default('box', True).with_pair('box', 'upper', False))
    assert checker.in_collision(scene.q)
    scene.set_acm(scene.acm.without(['box']).with_default('box', True))
    assert not checker.in_collision(scene.q)


@pytest.mark.parametrize(('touch_links', 'hit'), [((), True), (('finger',), False)])
def test_attached_object_is_checked_against_its_own_link(scene, touch_links, hit):
    """SCN-10: only touch links exempt, the carrying link too must be named."""
    checker = CollisionChecker(scene)
    item = CollisionObject(
        'cup', frame_id='finger', shapes=(ObjectShape(Sphere(0.04), pose_matrix((0.05, 0, 0))),))
    scene.apply_attached(AttachedObject('finger', item, touch_links))
    assert checker.in_collision(scene.q) == hit


def test_attached_objects_of_one_link_do_not_matter_to_each_other(scene):
    """SCN-10: but those of different links do, unless one names the other."""
    checker = CollisionChecker(scene)

    def attach(id_, link, *touch_links):
        scene.apply_attached(AttachedObject(
            link, thing(id_, Sphere(0.05), (0.9, 0.1, 0.0)), touch_links))

    attach('one', 'finger', 'finger')
    attach('two', 'finger', 'finger')
    assert not checker.in_collision(scene.q)
    attach('two', 'fore', 'fore', 'finger')
    attach('one', 'finger', 'finger', 'fore')
    assert checker.in_collision(scene.q)
    attach('two', 'fore', 'fore', 'finger', 'one')
    assert not checker.in_collision(scene.q)


def test_attached_object_moves_with_the_robot(scene):
    """SCN-10: what the arm carries collides where the arm takes it."""
    checker = CollisionChecker(scene)
    scene.apply_attached(AttachedObject(
        'finger', thing('stick', Box((0.3, 0.01, 0.01)), (1.1, 0, 0)), ('finger',)))
    scene.apply_object(thing('post', Cylinder(0.03, 0.2), (0.0, 1.2, 0.0)))
    assert not checker.in_collision(scene.q)
    turned = scene.kinematic_model.vector({'shoulder': math.pi / 2})
    contact, = checker.contacts(turned)
    assert {contact.type1, contact.type2} == {BodyType.ROBOT_ATTACHED, BodyType.WORLD_OBJECT}
    scene.apply_attached(AttachedObject('', CollisionObject('stick', REMOVE)))
    assert not checker.in_collision(turned)


def test_padding_counts_against_the_world_only(scene):
    """SCN-14: the world comes nearer by the padding, the robot's own links do not."""
    checker = CollisionChecker(scene)
    scene.apply_object(thing('ball', Sphere(0.1), (0.6, 0.135, 0.0)))
    bent = scene.kinematic_model.vector({'elbow': 2.6})
    free = checker.distance(bent)
    assert not checker.in_collision(scene.q)
    scene.apply(SceneUpdate(link_padding={'fore': 0.02}))
    contact, = checker.contacts(scene.q)
    assert contact.depth == pytest.approx(0.01, abs=1e-6)
    assert checker.in_collision(scene.q)
    assert checker.distance(scene.q) == pytest.approx(-0.01, abs=1e-6)
    assert checker.in_collision(bent) == (free <= 0.0)
    scene.apply(SceneUpdate(link_padding={'fore': 0.0}))
    assert not checker.in_collision(scene.q)


def test_scale_counts_against_the_world_only(scene):
    """SCN-14: a scaled link is larger for the world and as it is for the robot."""
    checker = CollisionChecker(scene)
    scene.apply_object(thing('ball', Sphere(0.1), (0.6, 0.135, 0.0)))
    assert not checker.in_collision(scene.q)
    scene.apply(SceneUpdate(link_scale={'fore': 1.5, 'base': 20.0}))
    assert {c.body1 for c in checker.contacts(scene.q)} == {'fore', 'base'}
    scene.apply_object(CollisionObject('', REMOVE))
    assert not checker.in_collision(scene.q)


def test_padding_and_scale_of_a_link_are_those_of_what_it_carries(scene):
    """Against the world only (upstream's CollisionEnvFCL::getAttachedBodyObjects)."""
    checker = CollisionChecker(scene)
    for link, id_, radius, at in (('finger', 'cup', 0.05, 0.0), ('base', 'pin', 0.01, 0.065)):
        scene.apply_attached(
            AttachedObject(link, thing(id_, Sphere(radius), (1.0, at, 0)), (link,)))
    scene.apply_object(thing('wall', Box((0.1, 1, 1)), (1.11, 0, 0)))
    assert checker.distance(scene.q) == pytest.approx(0.005, abs=1e-6)
    scene.apply(SceneUpdate(link_padding={'finger': 0.02}))
    contact, = checker.contacts(scene.q)
    assert (contact.body1, contact.body2) == ('cup', 'wall')
    assert contact.depth == pytest.approx(0.01, abs=1e-6)
    scene.apply(SceneUpdate(link_padding={'finger': 0.0}, link_scale={'finger': 1.4}))
    contact, = checker.contacts(scene.q)
    assert (contact.body1, contact.body2) == ('cup', 'wall')
    assert contact.depth == pytest.approx(0.01, abs=1e-6)
    scene.apply(SceneUpdate(link_scale={'finger': 1.0}))
    assert not checker.in_collision(scene.q)


def test_group_looks_at_what_it_moves(scene):
    """SCN-15: links of the group and all below, against the world and all other links."""
    checker = CollisionChecker(scene)
    scene.apply_object(thing('at_upper', Box((0.1, 0.1, 0.1)), (0.2, 0, 0)))
    assert checker.in_collision(scene.q)
    assert checker.in_collision(scene.q, 'arm')
    assert not checker.in_collision(scene.q, 'hand')
    scene.apply_object(thing('at_finger', Box((0.1, 0.1, 0.1)), (0.87, 0, 0)))
    assert [c.body2 for c in checker.contacts(scene.q, 'hand')] == ['at_finger']
    with pytest.raises(PlanningError) as caught:
        checker.in_collision(scene.q, 'leg')
    assert caught.value.code == -15


def test_static_links_count_without_a_group(scene):
    """SRV-20: without a group all links are looked at, the base too."""
    checker = CollisionChecker(scene)
    scene.apply_object(thing('floor', Plane(0, 0, 1, 0.04), (0, 0, 0)))
    assert [c.body1 for c in checker.contacts(scene.q)] == ['base']
    assert checker.in_collision(scene.q)
    assert checker.in_collision(scene.q, exact=False)
    assert not checker.in_collision(scene.q, 'arm')


def test_a_plane_is_infinitely_thin(scene):
    """Only what crosses a plane touches it (upstream's createCollisionGeometry)."""
    checker = CollisionChecker(scene)
    for height, hits in ((0.06, False), (0.04, True), (0.0, True), (-0.04, True), (-0.06, False)):
        scene.apply_object(thing('floor', Plane(0, 0, 1, -height), (0, 0, 0)))
        for exact in (True, False):
            assert checker.in_collision(scene.q, exact=exact) == hits, (height, exact)
        assert bool(checker.contacts(scene.q)) == hits
        assert (checker.distance(scene.q) <= 0.0) == hits
    assert checker.distance(scene.q) == pytest.approx(0.01, abs=1e-6)


@pytest.mark.parametrize('tilt', [(0, 0, 0), (0.3, 0.2, 0.1)])
def test_a_plane_has_a_distance_from_a_mesh(mesh_kinematics, tilt):
    """That of the nearest triangle, on both sides, not positive where a triangle crosses."""
    scene = PlanningScene(mesh_kinematics)
    checker = CollisionChecker(scene)
    normal = pose_matrix((0, 0, 0), tilt)[:3, 2]
    reach = np.abs(normal) @ (0.15, 0.025, 0.025)
    for way in (reach + 0.02, reach - 0.02, 0.0, -reach - 0.02):
        scene.apply_object(
            thing('sheet', Plane(0, 0, 1, 0), np.array([0.2, 0, 0]) + way * normal, tilt))
        found = {pair.names: pair.distance for pair in checker.pair_distances(scene.q, 0.05)}
        distance = found['upper', 'sheet']
        assert checker.in_collision(scene.q) or distance == pytest.approx(abs(way) - reach)
        assert (distance <= 0.0) == (abs(way) < reach)


def test_a_mesh_is_a_surface(scene, make_mesh):
    """What is wholly inside of a mesh does not touch it; what crosses its faces does."""
    checker = CollisionChecker(scene)
    scene.apply_object(thing('hall', make_mesh(4.0), (0, 0, 0)))
    assert not checker.in_collision(scene.q)
    scene.apply_object(thing('hall', make_mesh(4.0), (2.5, 0, 0)))
    assert checker.in_collision(scene.q)


def test_object_with_the_name_of_a_touch_link_is_no_link(scene):
    """SCN-10: touch links name links and attached objects, never the world."""
    checker = CollisionChecker(scene)
    scene.apply_attached(AttachedObject(
        'finger', thing('stick', Box((0.3, 0.01, 0.01)), (1.1, 0, 0)), ('finger', 'post')))
    scene.apply_object(thing('post', Cylinder(0.03, 0.2), (1.1, 0.0, 0.0)))
    assert checker.in_collision(scene.q)


def test_flat_mesh_has_no_hull_and_still_collides(make_robot):
    """A sheet of two triangles is a legal link."""
    sheet = Mesh(np.array([[-0.1, -0.1, 0], [0.1, -0.1, 0], [0.1, 0.1, 0], [-0.1, 0.1, 0.0]]),
                 np.array([[0, 1, 2], [0, 2, 3]]))
    scene = PlanningScene(KinematicModel(make_robot(upper_shape=sheet)))
    checker = CollisionChecker(scene)
    assert not checker.in_collision(scene.q)
    scene.apply_object(thing('pin', Cylinder(0.01, 0.1), (0.2, 0.09, 0.0)))
    assert checker.in_collision(scene.q)
    assert checker.in_collision(scene.q, exact=False)


@pytest.mark.parametrize('offset', [0.0, 1e-9, 1e-6, 1e-3])
def test_shapes_about_nearly_one_centre_touch(mesh_kinematics, offset):
    """However the inner one is turned: there GJK's first direction says next to nothing."""
    scene = PlanningScene(mesh_kinematics)
    checker = CollisionChecker(scene)
    rng = np.random.default_rng(7)
    for _ in range(40):
        at = np.array([0.6, 0.0, 0.0]) + offset * rng.normal(size=3)
        scene.apply_object(thing('core', Box((0.1, 0.2, 0.3)), at, rng.uniform(-3, 3, 3)))
        assert checker.in_collision(scene.q, exact=False)
        assert checker.in_collision(scene.q)


def test_a_judge_holds_until_something_else_is_asked(scene):
    """It is the same one for the same question, and knows edits and other clearances."""
    checker = CollisionChecker(scene)
    test = checker.test('arm', 0.02)
    assert checker.test('arm', 0.02) is test
    assert not test(scene.q)
    scene.apply_object(thing('near', Sphere(0.1), (0.6, 0.135, 0.0)))
    assert checker.test('arm', 0.02)(scene.q)
    assert not checker.test('arm', 0.0)(scene.q)
    assert checker.distance(scene.q) == pytest.approx(0.01, abs=1e-6)
    assert checker.test('arm', 0.02)(scene.q)


def test_checker_outlives_everything_that_was_given_to_it(make_robot):
    """Nobody else needs to keep scene, model or meshes alive."""
    checker = CollisionChecker(PlanningScene(KinematicModel(make_robot())))
    q = checker.scene.kinematic_model.vector({'elbow': 3.05})
    assert [checker.in_collision(q) for _ in range(50)] == [True] * 50


def test_displacement_bound_holds(scene, make_mesh):
    """No corner of a link or load moves farther than the bound, on random segments."""
    clutter(scene, make_mesh)
    checker = CollisionChecker(scene)
    kinematics = scene.kinematic_model
    held = scene.attached['held']
    rng = np.random.default_rng(3)
    tightest = 0.0
    for q1, q2 in zip(states(scene, 60, 1), states(scene, 60, 2), strict=True):
        q2 = q1 + (q2 - q1) * rng.choice([0.02, 0.3, 1.0])
        bound = checker.displacement_bound(q1, q2)
        for along in (0.25, 0.5, 1.0):
            q = q1 + along * (q2 - q1)
            for link, point in (
                ('upper', (0.35, 0.025, 0.025, 1)), ('fore', (0.35, -0.025, 0.025, 1)),
                ('finger', (0.08, 0, 0, 1)), (held.link_name, held.object.pose[:, 3]),
            ):
                one, other = (
                    kinematics.link_pose(state, link) @ np.array(point, float)
                    for state in (q1, q)
                )
                moved = float(np.linalg.norm(one - other))
                assert moved <= bound + 1e-9
                tightest = max(tightest, moved / bound)
    assert tightest > 0.5


@pytest.mark.parametrize('id_', ['fore', 'held'])
def test_displacement_bound_holds_for_scaled_shapes(scene, make_mesh, id_):
    """What is scaled reaches farther from the joints, and so does what a scaled link carries."""
    clutter(scene, make_mesh)
    checker = CollisionChecker(scene)
    turned = scene.kinematic_model.vector({'shoulder': 0.01})
    before = checker.displacement_bound(scene.q, turned)
    scene.apply(SceneUpdate(link_scale={'fore' if id_ == 'fore' else 'finger': 5.0}))
    assert checker.displacement_bound(scene.q, turned) > before + 0.001


def test_displacement_bound_is_zero_without_motion(scene):
    """Standing still moves nothing; a group that stands still neither."""
    checker = CollisionChecker(scene)
    assert checker.displacement_bound(scene.q, scene.q) == 0.0
    turned = scene.kinematic_model.vector({'shoulder': 0.1})
    assert checker.displacement_bound(scene.q, turned, 'hand') > 0.0
    assert 0.0 < checker.displacement_bound(scene.q, turned) < 0.1
