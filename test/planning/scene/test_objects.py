# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""World objects: add, append, move, remove."""

import math

import numpy as np
import pytest

from armsim_ros.errors import PlanningError
from armsim_ros.model.geometry import Box, Cone, Cylinder, Mesh, Plane, Sphere
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.scene.objects import (
    CollisionObject,
    message_pose,
    ObjectOperation,
    ObjectShape,
    ObjectType,
)
from armsim_ros.planning.scene.update import SceneUpdate

ADD, REMOVE, APPEND, MOVE = ObjectOperation
BOX = Box((0.1, 0.2, 0.3))


def box(id_='box', operation=ADD, at=(1.0, 0.0, 0.0), **changes):
    """Return an update with one box."""
    values = {'shapes': (ObjectShape(BOX, pose_matrix(at)),)}
    return CollisionObject(id_, operation, **{**values, **changes})


def test_add_creates_and_replaces(scene):
    """SCN-1: ADD makes an object, a second ADD of the same id takes its place."""
    scene.apply_object(box())
    scene.apply_object(CollisionObject(
        'box', shapes=(ObjectShape(Sphere(0.1)), ObjectShape(Sphere(0.2)))))
    assert [shape.geometry for shape in scene.objects['box'].shapes] == [Sphere(0.1), Sphere(0.2)]


def test_shape_pose_of_a_single_shape_becomes_the_object_pose(scene):
    """SCN-3: without a pose of its own the object stands where its only shape stands."""
    scene.apply_object(box(at=(1.0, 2.0, 3.0)))
    np.testing.assert_allclose(scene.objects['box'].pose, pose_matrix((1.0, 2.0, 3.0)))
    np.testing.assert_allclose(scene.objects['box'].shapes[0].pose, np.eye(4))


def test_object_pose_and_shape_pose_compose(scene):
    """SCN-3: shapes stand in the object's frame, the object in the header's."""
    scene.set_positions({'shoulder': math.pi / 2})
    pose = pose_matrix((0.5, 0.0, 0.0))
    scene.apply_object(box(frame_id='upper', pose=pose, at=(0.0, 0.1, 0.0)))
    item = scene.objects['box']
    np.testing.assert_allclose(item.pose[:3, 3], (0.0, 0.5, 0.0), atol=1e-12)
    np.testing.assert_allclose((item.pose @ item.shapes[0].pose)[:3, 3], (-0.1, 0.5, 0.0),
                               atol=1e-12)


def test_missing_shape_poses_are_identity(scene):
    """SCN-2: fewer poses than shapes is allowed."""
    scene.apply_object(CollisionObject(
        'two', shapes=(ObjectShape(BOX, pose_matrix((1, 0, 0))), ObjectShape(BOX))))
    np.testing.assert_array_equal(scene.objects['two'].shapes[1].pose, np.eye(4))


def test_zero_quaternion_reads_as_identity():
    """SCN-3: an all-zero quaternion is no rotation."""
    np.testing.assert_array_equal(message_pose((1, 2, 3), (0, 0, 0, 0)), pose_matrix((1, 2, 3)))


def test_quaternion_of_any_length_is_normalized():
    """A tiny or huge quaternion has a direction all the same."""
    for factor in (1e-200, 1e200):
        pose = message_pose((0, 0, 0), (0, 0, factor, factor))
        np.testing.assert_allclose(pose, pose_matrix((0, 0, 0), (0, 0, math.pi / 2)), atol=1e-12)


@pytest.mark.parametrize('pose', [pose_matrix(), pose_matrix((5.0, 0.0, 0.0))])
def test_append_adds_shapes_in_the_object_frame(scene, pose):
    """
    APPEND keeps the object's pose; the message's header and pose do not count.

    moveit_core planning_scene.cpp, processCollisionObjectAdd; world.cpp, addToObject.
    """
    scene.apply_object(box(at=(1.0, 0.0, 0.0), subframes={'old': pose_matrix()}))
    offsets = (pose_matrix((0.0, 0.5, 0.0)), pose_matrix((0.0, 0.6, 0.0)))
    scene.apply_object(CollisionObject(
        'box', APPEND, 'fore', pose,
        tuple(ObjectShape(Sphere(0.1), offset) for offset in offsets),
        subframes={'top': pose_matrix()}))
    item = scene.objects['box']
    np.testing.assert_allclose(item.pose, pose_matrix((1.0, 0.0, 0.0)))
    for shape, offset in zip(item.shapes[1:], offsets, strict=True):
        np.testing.assert_allclose(shape.pose, offset)
    assert set(item.subframes) == {'top'}


def test_append_of_a_single_shape_without_object_pose_is_at_the_origin(scene):
    """
    The pose of an only shape is read as the object's, which APPEND ignores.

    moveit_core planning_scene.cpp, shapesAndPosesFromCollisionObjectMessage.
    """
    scene.apply_object(box(subframes={'old': pose_matrix()}))
    scene.apply_object(box(operation=APPEND, at=(0.0, 7.0, 0.0)))
    np.testing.assert_allclose(scene.objects['box'].shapes[1].pose, np.eye(4))
    assert not scene.objects['box'].subframes


def test_append_to_nothing_creates(scene):
    """SCN-1: APPEND of an unknown id is an ADD."""
    scene.apply_object(box(operation=APPEND))
    assert 'box' in scene.objects


def test_move_moves_shapes_and_subframes(scene):
    """SCN-6, SCN-7: MOVE with a pose moves the object and all that is fixed to it."""
    scene.apply_object(box(subframes={'top': pose_matrix((0, 0, 0.15))}))
    scene.apply_object(CollisionObject('box', MOVE, pose=pose_matrix((0, 3, 0))))
    np.testing.assert_allclose(scene.frame_pose('box'), pose_matrix((0, 3, 0)))
    np.testing.assert_allclose(scene.frame_pose('box/top'), pose_matrix((0, 3, 0.15)))


def test_move_to_the_identity_is_a_move(scene):
    """
    MOVE with the identity brings the object to the origin of the header's frame.

    moveit_core planning_scene.cpp, processCollisionObjectMove.
    """
    scene.apply_object(box())
    scene.apply_object(CollisionObject('box', MOVE, 'fore', pose_matrix()))
    np.testing.assert_allclose(scene.objects['box'].pose, pose_matrix((0.4, 0, 0)), atol=1e-12)


@pytest.mark.parametrize('pose', [pose_matrix(), pose_matrix((0, 1, 0))])
def test_move_can_place_the_shapes(scene, pose):
    """
    Shape poses of a MOVE are one for each shape, in the object's frame, whatever their kind.

    moveit_core planning_scene.cpp, processCollisionObjectMove.
    """
    scene.apply_object(CollisionObject('two', shapes=(ObjectShape(BOX), ObjectShape(BOX))))
    poses = (pose_matrix((1, 0, 0)), pose_matrix((2, 0, 0)))
    scene.apply_object(CollisionObject('two', MOVE, pose=pose, shape_poses=poses))
    np.testing.assert_allclose(scene.objects['two'].pose, pose)
    np.testing.assert_allclose(scene.objects['two'].shapes[1].pose, poses[1])


def test_remove_drops_color_and_matrix_entry(scene):
    """SCN-5, SCN-13: what the scene knew about the object goes with it."""
    scene.apply_object(box())
    scene.apply(SceneUpdate(object_colors={'box': (1.0, 0.0, 0.0, 1.0)}))
    scene.set_acm(scene.acm.with_entry('box', True))
    scene.apply_object(CollisionObject('box', REMOVE))
    assert not scene.objects
    assert not scene.colors
    assert 'box' not in scene.acm.names
    assert not scene.acm.allowed('box', 'upper')


def test_remove_without_an_id_takes_all(scene):
    """SCN-5: an empty id means every object in the world."""
    scene.apply_object(box('one'))
    scene.apply_object(box('two'))
    scene.apply_object(CollisionObject('', REMOVE))
    assert not scene.objects


def test_add_keeps_a_type_given_before(scene):
    """The type stays until another one is given."""
    scene.apply_object(box(type=ObjectType('cup', 'db')))
    scene.apply_object(box())
    assert scene.objects['box'].type.key == 'cup'


def test_leading_slash_of_a_frame_is_dropped(scene):
    """SCN-2: ``/world`` is ``world``."""
    scene.apply_object(box(frame_id='/world'))
    assert 'box' in scene.objects


@pytest.mark.parametrize('shape', [
    BOX, Sphere(0.1), Cylinder(0.1, 0.2), Cone(0.1, 0.2), Plane(0, 0, 1, 0.5),
], ids=lambda shape: type(shape).__name__)
def test_every_kind_of_shape_is_taken(scene, shape):
    """SCN-4: box, sphere, cylinder, cone and plane."""
    scene.apply_object(CollisionObject('thing', shapes=(ObjectShape(shape),)))
    assert scene.objects['thing'].shapes[0].geometry is shape


NAN = float('nan')
ROTTEN = {
    'no shape': CollisionObject('box', pose=pose_matrix((9, 0, 0))),
    'unknown frame': box(frame_id='nowhere'),
    'unknown operation': box(operation=7),
    'octomap': box('<octomap>'),
    'empty id': box(''),
    'box without extent': box(shapes=(ObjectShape(Box((0.1, 0.0, 0.1))),)),
    'negative radius': box(shapes=(ObjectShape(Sphere(-0.1)),)),
    'size not finite': box(shapes=(ObjectShape(Cylinder(0.1, NAN)),)),
    'pose not finite': box(pose=np.full((4, 4), NAN)),
    'pose without a rotation': box(pose=np.diag([2.0, 1.0, 1.0, 1.0])),
    'pose beyond all bounds': box(at=(1e200, 0, 0)),
    'plane without a normal': CollisionObject('box', shapes=(ObjectShape(Plane(0, 0, 0, 1)),)),
    'mesh without triangles': CollisionObject(
        'box', shapes=(ObjectShape(Mesh(np.zeros((3, 3)), np.empty((0, 3), int))),)),
    'mesh with a missing vertex': CollisionObject(
        'box', shapes=(ObjectShape(Mesh(np.zeros((3, 3)), np.array([[0, 1, 3]]))),)),
    'subframe not finite': box(subframes={'top': np.full((4, 4), NAN)}),
    'remove of nothing': CollisionObject('ghost', REMOVE),
    'move of nothing': CollisionObject('ghost', MOVE, pose=pose_matrix()),
    'move to an unknown frame': CollisionObject('box', MOVE, 'nowhere', pose_matrix()),
    'move with too many poses': CollisionObject(
        'box', MOVE, pose=pose_matrix((5, 0, 0)), shape_poses=(pose_matrix(),) * 2),
}


@pytest.mark.parametrize('what', ROTTEN)
def test_refused_edit_leaves_the_scene_as_it_was(scene, what):
    """SCN-2, SCN-2a, SCN-6: a refused operation has a reason and no effect at all."""
    scene.apply_object(box())
    before = scene.content
    with pytest.raises(PlanningError) as caught:
        scene.apply_object(ROTTEN[what])
    assert len(str(caught.value)) > 20
    assert scene.content is before


@pytest.mark.parametrize(('shape', 'named'), [
    (Sphere(-0.1), 'primitive 1'), (Plane(0, 0, 0, 1), 'plane 1'),
    (Mesh(np.zeros((3, 3)), np.empty((0, 3), int)), 'mesh 1')])
def test_a_refusal_names_the_shape(scene, shape, named):
    """Kind and number of a shape that cannot be used are in the message."""
    with pytest.raises(PlanningError, match=f"{named} of object 'box'"):
        scene.apply_object(box(shapes=(ObjectShape(BOX), ObjectShape(shape))))
