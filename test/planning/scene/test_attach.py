# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Attaching objects to links and detaching them."""

import math

import numpy as np
import pytest

from armsim_ros.errors import PlanningError
from armsim_ros.model.geometry import Box, Sphere
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.scene.objects import (
    AttachedObject,
    CollisionObject,
    ObjectOperation,
    ObjectShape,
)
from armsim_ros.planning.scene.update import SceneUpdate

ADD, REMOVE, APPEND, MOVE = ObjectOperation


def cup(operation=ADD, **changes):
    """Return an update of an object with a shape 1 m ahead."""
    values = {'shapes': (ObjectShape(Sphere(0.05), pose_matrix((0.9, 0, 0))),)}
    return CollisionObject(**{'id': 'cup', 'operation': operation, **values, **changes})


def by_id(id_='cup', operation=ADD, link='fore', **changes):
    """Return an update without geometry."""
    return AttachedObject(link, CollisionObject(id_, operation), **changes)


def test_attach_takes_the_world_object_with_it(scene):
    """SCN-8: the object leaves the world, keeps its place and then moves with the link."""
    scene.apply_object(cup(subframes={'rim': pose_matrix((0, 0, 0.05))}))
    scene.apply_attached(by_id())
    assert not scene.objects
    np.testing.assert_allclose(scene.frame_pose('cup'), pose_matrix((0.9, 0, 0)), atol=1e-12)
    scene.set_positions({'shoulder': math.pi / 2})
    np.testing.assert_allclose(scene.frame_pose('cup')[:3, 3], (0, 0.9, 0), atol=1e-12)
    np.testing.assert_allclose(scene.frame_pose('cup/rim')[:3, 3], (0, 0.9, 0.05), atol=1e-12)


def test_attach_with_geometry_replaces_the_world_object(scene):
    """SCN-8: geometry in the message wins; its pose is in the header's frame."""
    scene.apply_object(cup())
    item = CollisionObject(
        'cup', frame_id='fore',
        shapes=(ObjectShape(Box((0.1, 0.1, 0.1)), pose_matrix((0.45, 0, 0))),))
    scene.apply_attached(AttachedObject('fore', item, ('fore',)))
    assert not scene.objects
    attached = scene.attached['cup']
    assert attached.object.shapes[0].geometry == Box((0.1, 0.1, 0.1))
    np.testing.assert_allclose(attached.object.pose, pose_matrix((0.45, 0, 0)), atol=1e-12)


def test_same_id_again_replaces(scene):
    """SCN-8: an attached object can be attached anew with its shapes, here to another link."""
    scene.apply_attached(AttachedObject('fore', cup(), ('fore',)))
    scene.apply_attached(AttachedObject('finger', cup(), ('finger', 'finger')))
    assert scene.attached['cup'].link_name == 'finger'
    assert scene.attached['cup'].touch_links == ('finger',)
    np.testing.assert_allclose(scene.frame_pose('cup'), pose_matrix((0.9, 0, 0)), atol=1e-12)


def test_append_merges_shapes_and_touch_links(scene):
    """
    APPEND keeps the pose on the link; the new shapes are in the object's frame, before the old.

    moveit_core planning_scene.cpp, processAttachedCollisionObjectMsg.
    """
    scene.apply_attached(AttachedObject('fore', cup(subframes={'rim': pose_matrix()}), ('fore',),
                                        weight=0.2))
    offsets = (pose_matrix((0.1, 0, 0)), pose_matrix((0.2, 0, 0)))
    more = cup(APPEND, shapes=tuple(ObjectShape(Sphere(0.02), offset) for offset in offsets),
               subframes={'top': pose_matrix()})
    scene.apply_attached(AttachedObject('fore', more, ('finger',)))
    attached = scene.attached['cup']
    assert [shape.geometry.radius for shape in attached.object.shapes] == [0.02, 0.02, 0.05]
    assert attached.touch_links == ('fore', 'finger')
    assert attached.weight == 0.2
    assert set(attached.object.subframes) == {'rim', 'top'}
    np.testing.assert_allclose(scene.frame_pose('cup'), pose_matrix((0.9, 0, 0)), atol=1e-12)
    np.testing.assert_allclose(attached.object.shapes[1].pose, offsets[1])


def test_append_with_a_pose_moves_the_attached_object(scene):
    """
    The pose of the message, where one is given, becomes that of the object.

    moveit_core planning_scene.cpp, processAttachedCollisionObjectMsg.
    """
    scene.apply_attached(AttachedObject('fore', cup()))
    scene.apply_attached(AttachedObject('fore', cup(APPEND, pose=pose_matrix((0.7, 0, 0)))))
    np.testing.assert_allclose(scene.frame_pose('cup'), pose_matrix((0.7, 0, 0)), atol=1e-12)


def test_detach_returns_the_object_where_it_is(scene):
    """SCN-9: the object comes back to the world at its present pose, with its colour."""
    scene.apply_object(cup())
    scene.apply(SceneUpdate(object_colors={'cup': (0.0, 1.0, 0.0, 0.5)}))
    scene.apply_attached(by_id())
    scene.set_positions({'shoulder': math.pi / 2})
    scene.apply_attached(by_id(operation=REMOVE))
    assert not scene.attached
    np.testing.assert_allclose(scene.objects['cup'].pose[:3, 3], (0, 0.9, 0), atol=1e-12)
    assert scene.colors['cup'] == (0.0, 1.0, 0.0, 0.5)


def test_detached_object_yields_to_one_in_the_world(scene):
    """SCN-9: where the world already has the id, the detached object is dropped."""
    scene.apply_attached(AttachedObject('fore', cup()))
    scene.apply_object(cup(shapes=(ObjectShape(Sphere(0.2)),)))
    scene.apply_attached(by_id(operation=REMOVE))
    assert scene.objects['cup'].shapes[0].geometry == Sphere(0.2)


@pytest.mark.parametrize(('link', 'left'), [('fore', {'c'}), ('', set())])
def test_detach_without_an_id_takes_all_of_a_link_or_all(scene, link, left):
    """SCN-9: an empty id means everything on the link; without a link, everything."""
    for id_, carrier in (('a', 'fore'), ('b', 'fore'), ('c', 'finger')):
        item = CollisionObject(id_, shapes=(ObjectShape(Sphere(0.05)),))
        scene.apply_attached(AttachedObject(carrier, item))
    scene.apply_attached(by_id('', REMOVE, link))
    assert set(scene.attached) == left


ROTTEN = {
    'unknown link': by_id(link='nose'),
    'nothing to attach': by_id('ghost'),
    'empty id': by_id(''),
    'detach of nothing': by_id('ghost', REMOVE),
    'detach from another link': by_id('held', REMOVE, 'finger'),
    'detach from an unknown link': by_id('held', REMOVE, 'nose'),
    'move': by_id('held', MOVE),
    'append on another link': AttachedObject('finger', cup(APPEND, id='held')),
    'append without shapes': by_id('cup', APPEND),
    'attached already': by_id('held', link='finger'),
    'unknown operation': by_id('held', 9),
    'geometry in an unknown frame': AttachedObject('fore', cup(frame_id='nowhere')),
}


@pytest.mark.parametrize('what', ROTTEN)
def test_refused_attach_leaves_the_scene_as_it_was(scene, what):
    """SCN-8, SCN-9: a refused operation has a reason and no effect at all."""
    held = CollisionObject('held', shapes=(ObjectShape(Sphere(0.05)),))
    scene.apply_object(cup())
    scene.apply_attached(AttachedObject('fore', held))
    before = scene.content
    with pytest.raises(PlanningError) as caught:
        scene.apply_attached(ROTTEN[what])
    assert len(str(caught.value)) > 20
    assert scene.content is before
