# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Scene messages: differences, whole scenes, and what of them is refused."""

import math

import numpy as np
import pytest
from scene_summary import summary

from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.model.geometry import Sphere
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.scene.allowed_collision_matrix import AcmUpdate
from armsim_ros.planning.scene.objects import (
    AttachedObject,
    CollisionObject,
    ObjectOperation,
    ObjectShape,
    ObjectType,
)
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import joined, MOST_REFUSALS, SceneUpdate, StartState

ADD, REMOVE, APPEND, MOVE = ObjectOperation
NO_STATE = StartState(is_diff=False)


def ball(id_='ball', at=(1.0, 0.0, 0.0), **changes):
    """Return an update that adds a sphere."""
    return CollisionObject(id_, shapes=(ObjectShape(Sphere(0.1), pose_matrix(at)),), **changes)


def held(id_='held', link='fore', **changes):
    """Return an update that attaches a sphere at the origin of a link."""
    item = CollisionObject(id_, frame_id=link, shapes=(ObjectShape(Sphere(0.02)),), **changes)
    return AttachedObject(link, item)


def removed(id_):
    """Return an update that removes an object."""
    return CollisionObject(id_, REMOVE)


def detached(id_):
    """Return an update that detaches an object."""
    return AttachedObject('', CollisionObject(id_, REMOVE))


# ---------------------------------------------------------------- part by part


NOWHERE = CollisionObject('lost', frame_id='nowhere', shapes=(ObjectShape(Sphere(0.1)),))
REFUSED = {
    'unknown padding link': {'link_padding': {'nose': 0.1}},
    'negative padding': {'link_padding': {'fore': -0.1}},
    'scale 0': {'link_scale': {'fore': 0.0}},
    'unknown scale link': {'link_scale': {'nose': 1.1}},
    'colour of nothing': {'object_colors': {'': (1.0, 0.0, 0.0, 1.0)}},
    'frame that is not a pose': {'fixed_frames': {'cam': np.full((4, 4), np.nan)}},
    'unknown joint': {'robot_state': StartState(('knee',), (0.0,))},
    'joint at no number': {'robot_state': StartState(('elbow',), (math.nan,))},
    'names without positions': {'robot_state': StartState(('elbow',), ())},
    'unknown link': {'robot_state': StartState(
        attached_objects=(AttachedObject('nose', ball('other')),))},
    'attached in an unknown frame': {'robot_state': StartState(
        attached_objects=(AttachedObject('tool', NOWHERE),))},
    'detach of nothing': {'robot_state': StartState(attached_objects=(detached('ghost'),))},
    'detach without is_diff': {'robot_state': StartState(
        attached_objects=(detached('held'),), is_diff=False)},
    'unknown frame': {'objects': (NOWHERE,)},
    'unknown operation': {'objects': (ball('it', operation=7),)},
    'unknown object': {'objects': (removed('ghost'),)},
    'unreadable': {'unreadable': (PlanningError(-19, 'a part that cannot exist'),)},
    'matrix that is not square': {'acm': AcmUpdate(('a', 'b'), ((True,),))},
    'defaults without values': {'acm': AcmUpdate(default_entry_names=('a',))},
    'matrix that contradicts itself': {'acm': AcmUpdate(
        ('a', 'b', 'a'), ((False, True, False), (False,) * 3, (False,) * 3))},
    'defaults that contradict': {'acm': AcmUpdate((), (), ('a', 'a'), (True, False))},
}
GOOD = {
    'name': 'other', 'objects': (ball('new'), CollisionObject('new', MOVE, pose=pose_matrix())),
    'link_padding': {'upper': 0.1}, 'link_scale': {'upper': 1.5},
    'object_colors': {'old': (0.0, 1.0, 0.0, 1.0)},
    'fixed_frames': {'table': np.eye(4)},
    'robot_state': StartState(('elbow',), (0.5,)),
    'acm': AcmUpdate(('a', 'b'), ((False, True), (False, False))),
}


@pytest.mark.parametrize('what', REFUSED)
def test_a_refused_part_changes_nothing_and_stops_no_other(scene, what):
    """
    Each part of a scene message is applied or refused for itself.

    moveit_core planning_scene.cpp, setPlanningSceneDiffMsg.
    """
    scene.apply_object(ball('old'))
    scene.apply_attached(held())
    bad = REFUSED[what]
    good = {key: value for key, value in GOOD.items() if key not in bad or key == 'objects'}
    expected = scene.with_update(SceneUpdate(**good))
    assert not expected.refusals
    with pytest.raises(PlanningError) as caught:
        scene.apply(SceneUpdate(**good | bad | {
            'objects': (*bad.get('objects', ()), *good['objects'])}))
    assert len(str(caught.value)) > 20
    assert summary(scene.content) == summary(expected.content)


def test_what_may_be_there_is_removed_before_the_new_is_added(scene):
    """
    Removing objects that are not there does not keep those after them from being added.

    moveit_ros planning_scene_interface.cpp sends such lists; planning_scene.cpp takes each object.
    """
    scene.apply_object(ball('a'))
    with pytest.raises(PlanningError, match="'b'"):
        scene.apply(SceneUpdate(robot_state=NO_STATE, objects=(
            removed('a'), removed('b'), ball('c'))))
    assert set(scene.objects) == {'c'}


def test_every_refusal_is_named(scene):
    """The error names all refused parts, with the code of the first one."""
    with pytest.raises(PlanningError, match=r"2 parts.*'nose'.*'ghost'") as caught:
        scene.apply(SceneUpdate(link_padding={'nose': 0.1}, objects=(removed('ghost'),)))
    assert caught.value.code == -18


def test_an_overlay_holds_what_could_be_applied(scene):
    """A difference for a request never reaches the scene; what it refuses is known."""
    overlay = scene.with_update(SceneUpdate(objects=(removed('ghost'), ball())))
    assert set(overlay.objects) == {'ball'}
    assert 'ghost' in overlay.refused
    assert 'ghost' in overlay.with_start_state(StartState()).refused
    assert not scene.objects
    assert not scene.refused


# ---------------------------------------------------------------- the robot's state in it


@pytest.mark.parametrize('is_diff', [True, False])
@pytest.mark.parametrize('whole', [True, False])
def test_a_robot_state_without_joints_clears_nothing(scene, is_diff, whole):
    """
    Attached objects stay where the robot state names no joint, also in a whole scene.

    moveit_core planning_scene.cpp, setCurrentState; conversions.cpp.
    """
    scene.apply_attached(held())
    scene.apply(SceneUpdate(is_diff=not whole, robot_state=StartState(is_diff=is_diff)))
    assert set(scene.attached) == {'held'}


@pytest.mark.parametrize(('is_diff', 'left'), [(True, {'held', 'new'}), (False, {'new'})])
@pytest.mark.parametrize('whole', [True, False])
def test_a_robot_state_with_joints_replaces_what_is_attached(scene, is_diff, left, whole):
    """
    With joints and is_diff false the attached objects are those of the message.

    moveit_core conversions.cpp, robotStateMsgToRobotStateHelper.
    """
    scene.apply_attached(held())
    scene.apply(SceneUpdate(is_diff=not whole, robot_state=StartState(
        ('elbow',), (0.5,), is_diff, (held('new'),))))
    assert set(scene.attached) == left
    assert not scene.objects


def test_a_refused_robot_state_keeps_what_is_attached(scene):
    """Joints that are refused clear no attached objects."""
    scene.apply_attached(held())
    with pytest.raises(PlanningError):
        scene.apply(SceneUpdate(robot_state=StartState(('knee',), (0.5,), False)))
    assert set(scene.attached) == {'held'}


# ---------------------------------------------------------------- whole scenes


def test_a_whole_scene_replaces_world_colours_types_and_matrix(scene):
    """
    Names, colours and types go with the old world; the matrix is the message's, also an empty one.

    moveit_core planning_scene.cpp, setPlanningSceneMsg.
    """
    scene.apply_object(ball('old', type=ObjectType('cup')))
    scene.apply_attached(held(type=ObjectType('cup')))
    scene.apply(SceneUpdate(name='first', object_colors={'old': (1, 1, 1, 1)},
                            fixed_frames={'table': np.eye(4)}))
    scene.apply(SceneUpdate(is_diff=False, objects=(ball('new'),)))
    assert set(scene.objects) == {'new'}
    assert not scene.colors
    assert scene.name == ''
    assert scene.attached['held'].object.type == ObjectType()
    assert not scene.acm.names
    assert not scene.acm.allowed('base', 'upper')
    assert scene.has_frame('table')


def test_a_whole_scene_keeps_paddings_that_it_does_not_name(scene):
    """
    Paddings and scales change for the links that the message names.

    moveit_core collision_env.cpp, setPadding and setScale.
    """
    scene.apply(SceneUpdate(link_padding={'fore': 0.1}, link_scale={'fore': 1.5}))
    scene.apply(SceneUpdate(is_diff=False, link_padding={'upper': 0.2}))
    assert (scene.link_padding['fore'], scene.link_padding['upper']) == (0.1, 0.2)
    assert scene.link_scale['fore'] == 1.5


def test_a_whole_scene_attaches_objects_of_the_old_world_by_id(scene):
    """
    The robot state is applied before the world is cleared.

    moveit_core planning_scene.cpp, setPlanningSceneMsg.
    """
    scene.apply_object(ball('cup'))
    by_id = AttachedObject('fore', CollisionObject('cup'))
    scene.apply(SceneUpdate(is_diff=False, robot_state=StartState(attached_objects=(by_id,))))
    assert set(scene.attached) == {'cup'}
    assert not scene.objects


@pytest.mark.parametrize('objects', [(), (ball('new'),)])
def test_a_world_replaces_the_world(scene, objects):
    """
    The objects of a world message take the place of all others; attached ones and rules stay.

    moveit_ros planning_scene_monitor.cpp, newPlanningSceneWorldCallback.
    """
    scene.apply_object(ball('old'))
    scene.apply_attached(held())
    before = scene.acm
    scene.apply(SceneUpdate(objects=objects, replaces_world=True))
    assert set(scene.objects) == {item.id for item in objects}
    assert set(scene.attached) == {'held'}
    assert scene.acm is before


ROW = ((False, True), (False, False))


@pytest.mark.parametrize(('update', 'whole'), [
    (SceneUpdate(is_diff=False), True),
    (SceneUpdate(replaces_world=True), True),
    (SceneUpdate(acm=AcmUpdate(('a', 'b'), ROW)), True),
    (SceneUpdate(link_padding={'fore': 0.1}), True),
    (SceneUpdate(link_scale={'fore': 1.1}), True),
    (SceneUpdate(name='other'), True),
    (SceneUpdate(name='this'), False),
    (SceneUpdate(objects=(ball(),)), False),
    (SceneUpdate(robot_state=StartState(attached_objects=(held(),))), False),
    (SceneUpdate(object_colors={'a': (1.0, 0.0, 0.0, 1.0)}), False),
    (SceneUpdate(fixed_frames={'a': np.eye(4)}), False),
])
def test_followers_need_the_whole_scene_after_some_updates(kinematics, update, whole):
    """
    A whole scene, a world, and a matrix, padding, scale or another name go out in full.

    moveit_ros planning_scene_monitor.cpp, newPlanningSceneMessage.
    """
    scene = PlanningScene(kinematics, name='this')
    scene.apply(update)
    assert bool(scene.content.whole_version) == whole


# ---------------------------------------------------------------- rules and colours


def test_matrix_of_a_difference_replaces_the_whole(scene):
    """A matrix is not merged with the old one; one with only defaults changes nothing."""
    before = scene.acm
    scene.apply(SceneUpdate(acm=AcmUpdate(default_entry_names=('a',),
                                          default_entry_values=(True,))))
    assert scene.acm is before
    scene.apply(SceneUpdate(acm=AcmUpdate(('a', 'b'), ROW)))
    assert scene.acm.allowed('b', 'a')
    assert not scene.acm.allowed('base', 'upper')


def test_a_name_that_is_there_twice_may_say_the_same(scene):
    """Only a contradiction is refused."""
    row = (False, True, False)
    scene.apply(SceneUpdate(acm=AcmUpdate(
        ('a', 'b', 'a'), (row, (True, False, True), row), ('a', 'a'), (False, False))))
    assert scene.acm.allowed('a', 'b')
    assert scene.acm.names == ('a', 'b')


def test_colours_are_not_checked(scene):
    """
    Any numbers are kept as a colour, also of an id that no object has.

    moveit_core planning_scene.cpp, setObjectColor.
    """
    scene.apply(SceneUpdate(object_colors={'x': (2.0, -1.0, math.inf, 0.0)}))
    assert scene.colors['x'] == (2.0, -1.0, math.inf, 0.0)


def test_a_detached_object_has_its_first_colour_again(scene):
    """
    The colour that an id was first given comes back when the object is detached.

    moveit_core planning_scene.cpp, processAttachedCollisionObjectMsg and setObjectColor.
    """
    red, green = (1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0, 1.0)
    scene.apply(SceneUpdate(objects=(ball('cup'),), object_colors={'cup': red}))
    scene.apply_attached(AttachedObject('fore', CollisionObject('cup')))
    scene.apply(SceneUpdate(object_colors={'cup': green}))
    scene.apply_attached(detached('cup'))
    assert scene.colors['cup'] == red


def test_colour_and_type_outlive_attaching(scene):
    """
    An attached object keeps colour and type, and has them again in the world.

    moveit_core test_collision_objects.cpp, rememberMetadataWhenAttached.
    """
    blue, kind = (0.0, 0.0, 1.0, 1.0), ObjectType('sphere', 'db')
    scene.apply(SceneUpdate(objects=(ball('cup', type=kind),), object_colors={'cup': blue}))
    scene.apply_attached(AttachedObject('fore', CollisionObject('cup')))
    assert (scene.colors['cup'], scene.attached['cup'].object.type) == (blue, kind)
    with pytest.raises(PlanningError, match='detach it first'):
        scene.apply_object(removed('cup'))
    scene.apply_attached(detached('cup'))
    assert (scene.colors['cup'], scene.objects['cup'].type) == (blue, kind)


def test_rules_of_an_object_outlive_attaching_and_end_with_it(scene):
    """
    Pairs of the matrix stay while an object is attached and detached, and go when it is removed.

    moveit_core test_planning_scene.cpp, UpdateACMAfterObjectRemoval.
    """
    for remove in ('cup', ''):
        scene.apply_object(ball('cup'))
        assert not scene.acm.allowed('cup', 'fore')
        scene.set_acm(scene.acm.with_pair('cup', 'fore', True))
        scene.apply_attached(AttachedObject('upper', CollisionObject('cup')))
        scene.apply_attached(detached('cup'))
        assert scene.acm.allowed('cup', 'fore')
        scene.apply_object(removed(remove))
        assert 'cup' not in scene.acm.names


@pytest.mark.parametrize(('count', 'end'), [
    (2, 'part 1'), (MOST_REFUSALS, f'part {MOST_REFUSALS - 1}'),
    (MOST_REFUSALS + 3, f'part {MOST_REFUSALS - 1}; and 3 more')])
def test_many_refusals_are_one_message(count, end):
    """With the number of all, the first ones, and how many are left out."""
    error = joined([PlanningError(MoveItErrorCode.FAILURE, f'part {number}')
                    for number in range(count)])
    assert error.code == MoveItErrorCode.FAILURE
    assert f'{count} parts are refused: ' in str(error)
    assert str(error).endswith(end)
