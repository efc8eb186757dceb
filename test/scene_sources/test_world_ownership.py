# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the simulated world may do to the scene, and what is the user's."""

import random

import numpy as np
import pytest

from armsim_ros.errors import PlanningError
from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.model.world_objects import WORLD_TYPE
from armsim_ros.nodes.conversions.collision_object import object_to_message
from armsim_ros.nodes.conversions.planning_scene import scene_to_message, update_from_message
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.scene.objects import (
    AttachedObject,
    CollisionObject,
    ObjectOperation,
    ObjectShape,
    ObjectType,
)
from armsim_ros.planning.scene.update import SceneUpdate, StartState
from armsim_ros.scene_sources.simulated_world import LATEST_COPY, of_world, WorldOwnership
from armsim_ros.stack import ArmSim

ADD, REMOVE, MOVE = ObjectOperation.ADD, ObjectOperation.REMOVE, ObjectOperation.MOVE


class Story:
    """A scene, its owner, and both who edit it."""

    def __init__(self, scene):
        self.scene = scene
        self.lines = []
        self.now = 0.0
        self.ownership = WorldOwnership(
            scene, ['base_link'], self.lines.append, lambda: self.now)
        self.epoch = '1'

    def world(self, *items):
        """Let the world tell: (id, operation, height) each."""
        kind = ObjectType(WORLD_TYPE, self.epoch)
        update = SceneUpdate(objects=tuple(item(*words, kind) for words in items))
        assert of_world(update)
        self.ownership.apply(update)

    def user(self, name, operation, height=5.0):
        """Let the user edit."""
        self.scene.apply_object(item(name, operation, height, ObjectType()))

    def hold(self, name, operation):
        """Let the world attach an object, or detach it."""
        held = CollisionObject(name, operation, type=ObjectType(WORLD_TYPE, self.epoch))
        self.ownership.apply(SceneUpdate(robot_state=StartState(
            attached_objects=(AttachedObject('link_6', held, ('link_5',)),))))

    def copy(self):
        """Return the whole scene as RViz publishes its copy of it."""
        return scene_to_message(self.scene.snapshot())

    def publish(self, copy):
        """Let the user publish a whole scene."""
        self.ownership.apply_client(update_from_message(copy, self.scene.model_frame))

    def heights(self):
        """Return id -> height of all objects in the world."""
        return {name: round(float(thing.pose[2, 3]), 6)
                for name, thing in self.scene.objects.items()}


def item(name, operation, height, kind):
    """Return the update of a box at a height [m]."""
    shapes = (ObjectShape(Box((0.1, 0.1, 0.1))),) if operation == ADD else ()
    return CollisionObject(
        name, operation, pose=pose_matrix((3.0, 0.0, height)), shapes=shapes, type=kind)


@pytest.fixture(scope='module')
def arm():
    """Return an arm whose scene has nothing of the world."""
    return ArmSim('sunday', overrides={'planning_parameters.scene_from_world': False})


@pytest.fixture
def story(arm):
    """Return a story that begins with an empty scene."""
    arm.scene.clear()
    return Story(arm.scene.snapshot())


def test_the_world_adds_moves_and_removes_its_own(story):
    """Its objects have no type in the scene, and may touch what stands."""
    story.world(('a', ADD, 1.0))
    assert story.scene.objects['a'].type == ObjectType()
    assert story.scene.acm.allowed('a', 'base_link')
    story.world(('a', MOVE, 2.0))
    assert story.heights() == {'a': 2.0}
    story.world(('a', REMOVE, 0.0))
    assert story.heights() == {}
    assert story.lines == []


def test_other_ids_are_never_touched(story):
    """An object that the user had before stays as it is, whatever the world says."""
    story.user('a', ADD)
    for operation in (ADD, MOVE, REMOVE, ADD):
        story.world(('a', operation, 1.0))
    story.epoch = '2'
    story.world(('a', ADD, 1.0))
    assert story.heights() == {'a': 5.0}
    assert len(story.lines) == 1


def test_what_the_user_adds_is_his(story):
    """The world stops writing it, until it deletes it or begins anew."""
    story.world(('a', ADD, 1.0), ('b', ADD, 1.0))
    story.user('a', ADD)
    story.world(('a', MOVE, 2.0), ('a', ADD, 2.0), ('b', MOVE, 2.0))
    assert story.heights() == {'a': 5.0, 'b': 2.0}
    assert ['no longer updated' in line for line in story.lines] == [True]
    story.epoch = '2'
    story.world(('a', ADD, 1.0), ('b', ADD, 1.0))
    assert story.heights() == {'a': 1.0, 'b': 1.0}


def test_a_users_object_outlives_that_of_the_world(story):
    """Deleted in the simulation, his own of that name stays; a new one stays out."""
    story.world(('a', ADD, 1.0))
    story.user('a', ADD)
    story.world(('a', REMOVE, 0.0))
    story.world(('a', ADD, 1.0))
    assert story.heights() == {'a': 5.0}


def test_what_the_user_removes_stays_away(story):
    """Also when all is told again; not after it was deleted and came anew."""
    story.world(('a', ADD, 1.0))
    story.user('a', REMOVE)
    story.world(('a', MOVE, 2.0), ('a', ADD, 2.0))
    assert story.heights() == {}
    story.world(('a', REMOVE, 0.0), ('a', ADD, 3.0))
    assert story.heights() == {'a': 3.0}


def test_a_new_epoch_leaves_nothing_of_the_old_one(story):
    """What the first message of an epoch does not name has gone."""
    story.world(('a', ADD, 1.0), ('b', ADD, 1.0))
    story.user('mine', ADD)
    story.epoch = '2'
    story.world(('b', ADD, 2.0))
    assert story.heights() == {'b': 2.0, 'mine': 5.0}


def test_what_the_user_attaches_is_his(story):
    """And stays on the link while the world goes on telling of it."""
    story.world(('a', ADD, 1.0))
    story.scene.apply_attached(AttachedObject('link_6', CollisionObject('a')))
    story.world(('a', MOVE, 2.0), ('a', ADD, 2.0))
    assert set(story.scene.attached) == {'a'}
    assert story.heights() == {}


def test_the_world_attaches_and_lets_go(story):
    """What it grasps goes with the link; let go it is in the world again, and still its own."""
    story.world(('a', ADD, 1.0))
    kind = ObjectType(WORLD_TYPE, '1')
    for operation in (ADD, REMOVE):
        attached = AttachedObject(
            'link_6', CollisionObject('a', operation, type=kind), ('link_5',))
        story.ownership.apply(SceneUpdate(robot_state=StartState(attached_objects=(attached,))))
        assert (set(story.scene.attached) == {'a'}) is (operation == ADD)
    story.world(('a', MOVE, 3.0))
    assert story.heights() == {'a': 3.0}
    assert story.lines == []


@pytest.mark.parametrize('other', ['z', 'Z'])
def test_what_the_world_grasps_is_free_of_what_it_rests_on(story, other):
    """In the physics it rests a few micrometres deep; attached it is as much higher."""
    story.world(('a', ADD, 1.0), (other, ADD, 0.9 + 8e-6))
    held = AttachedObject('link_6', CollisionObject('a', ADD, type=ObjectType(WORLD_TYPE, '1')))
    story.ownership.apply(SceneUpdate(robot_state=StartState(attached_objects=(held,))))
    scene = story.scene
    assert not [contact for contact in CollisionChecker(scene).contacts(scene.q)
                if 'a' in (contact.body1, contact.body2)]
    item = scene.attached['a']
    place = scene.kinematic_model.link_pose(scene.q, item.link_name) @ item.object.pose
    assert place[:3, 3] == pytest.approx((3.0, 0.0, 1.0), abs=1e-4)


def test_who_sends_a_scene_back_is_a_user(story):
    """What was read from the scene has no mark; a whole scene is the user's in any case."""
    story.world(('a', ADD, 1.0))
    assert not of_world(SceneUpdate(objects=tuple(story.scene.objects.values())))
    marked = item('a', ADD, 1.0, ObjectType(WORLD_TYPE, '1'))
    assert not of_world(SceneUpdate(is_diff=False, objects=(marked,)))
    assert not of_world(SceneUpdate())


def test_a_scene_that_is_applied_as_it_was_requested_changes_no_owner(story):
    """
    A client that edits the matrix of a scene sends all objects back; the world still moves them.

    Upstream, planning_scene.cpp, setPlanningSceneMsg adds the objects as they were.
    """
    turned = CollisionObject(
        'a', pose=pose_matrix((3.0, 0.0, 1.0), (0.1, 0.2, 0.3)),
        shapes=(ObjectShape(Box((0.1, 0.1, 0.1)), pose_matrix((0, 0, 0.1), (0.3, 0.2, 0.1))),),
        type=ObjectType(WORLD_TYPE, '1'))
    story.ownership.apply(SceneUpdate(objects=(turned, item('b', ADD, 1.0, turned.type))))
    held = AttachedObject('link_6', CollisionObject('b', ADD, type=turned.type), ('link_5',))
    story.ownership.apply(SceneUpdate(robot_state=StartState(attached_objects=(held,))))
    story.publish(story.copy())
    assert story.ownership.owned == {'a', 'b'}
    story.world(('a', MOVE, 2.0))
    assert story.heights() == {'a': 2.0}
    assert story.lines == []


def test_a_late_copy_changes_no_moving_object(story):
    """
    RViz publishes its whole copy with an object of its own; the world's are where they are now.

    Upstream, motion_planning_frame_objects.cpp, publishScene sends all that RViz has.
    """
    story.world(('carton', ADD, 1.0))
    copy = story.copy()
    story.now += 60.0
    story.world(('carton', MOVE, 1.2))
    copy.world.collision_objects.append(object_to_message(
        item('Box_0', ADD, 5.0, ObjectType()), story.scene.model_frame))
    story.now += 1.0
    story.publish(copy)
    assert story.heights() == {'carton': 1.2, 'Box_0': 5.0}
    story.world(('carton', MOVE, 1.4))
    assert story.heights()['carton'] == 1.4
    assert story.lines == []


def test_a_late_copy_leaves_a_new_object(story):
    """What the world added after the copy stays, with its colour, and may touch what stands."""
    story.world(('a', ADD, 1.0))
    copy = story.copy()
    blue = (0.0, 0.0, 1.0, 1.0)
    story.ownership.apply(SceneUpdate(
        objects=(item('b', ADD, 2.0, ObjectType(WORLD_TYPE, '1')),), object_colors={'b': blue}))
    story.publish(copy)
    assert story.heights() == {'a': 1.0, 'b': 2.0}
    assert story.scene.colors['b'] == blue
    assert story.scene.acm.allowed('b', 'base_link')
    assert story.ownership.owned == {'a', 'b'}


def test_a_late_copy_brings_no_deleted_object_back(story):
    """What the simulation has deleted since is not the user's; a new one is the world's."""
    story.world(('a', ADD, 1.0), ('b', ADD, 1.0))
    copy = story.copy()
    story.world(('b', REMOVE, 0.0))
    story.publish(copy)
    assert story.heights() == {'a': 1.0}
    assert 'b' not in story.scene.acm.to_update().entry_names
    story.world(('b', ADD, 2.0))
    assert story.heights() == {'a': 1.0, 'b': 2.0}


@pytest.mark.parametrize('operation', [ADD, REMOVE])
def test_a_late_copy_changes_no_grasp(story, operation):
    """What the world has grasped or released since stays so, and remains the world's."""
    story.world(('a', ADD, 1.0))
    if operation == REMOVE:
        story.hold('a', ADD)
    copy = story.copy()
    story.hold('a', operation)
    present = story.scene.content
    story.publish(copy)
    assert story.scene.attached == present.attached
    assert story.scene.objects == present.objects
    assert story.ownership.owned == {'a'}


def test_a_whole_scene_can_change_the_worlds_objects(story):
    """A place that the world has not reported lately is the user's, and so is a removal."""
    story.world(('a', ADD, 1.0), ('b', ADD, 1.0))
    story.world(('a', MOVE, 2.0))
    copy = story.copy()
    copy.world.collision_objects = [
        each for each in copy.world.collision_objects if each.id == 'a']
    copy.world.collision_objects[0].pose.position.z = 5.0
    story.now += LATEST_COPY + 1.0
    story.publish(copy)
    story.world(('a', MOVE, 3.0), ('b', MOVE, 3.0))
    assert story.heights() == {'a': 5.0}


def test_an_old_copy_is_the_users(story):
    """A pose that the world left long ago is where the user wants the object."""
    story.world(('a', ADD, 1.0))
    copy = story.copy()
    story.world(('a', MOVE, 2.0))
    story.now += LATEST_COPY + 1.0
    story.publish(copy)
    story.world(('a', MOVE, 3.0))
    assert story.heights() == {'a': 1.0}


def test_a_refused_part_of_a_late_copy_changes_no_owner(story):
    """The reason is raised, and the world's object is where it is now."""
    story.world(('a', ADD, 1.0))
    copy = story.copy()
    story.world(('a', MOVE, 2.0))
    copy.world.collision_objects.append(object_to_message(
        CollisionObject('flat'), story.scene.model_frame))
    with pytest.raises(PlanningError, match='no shape'):
        story.publish(copy)
    assert story.heights() == {'a': 2.0}
    assert story.ownership.owned == {'a'}


def test_a_difference_is_applied_as_it_is(story):
    """An object that a client sends by itself is the user's, also at an earlier pose."""
    story.world(('a', ADD, 1.0))
    earlier = story.scene.objects['a']
    story.world(('a', MOVE, 2.0))
    story.ownership.apply_client(SceneUpdate(objects=(earlier,)))
    story.world(('a', MOVE, 3.0))
    assert story.heights() == {'a': 1.0}


def test_a_wrong_object_does_not_keep_the_others_out(story):
    """The rest of the message is done, and the reason is raised."""
    wrong = CollisionObject('x', ADD, type=ObjectType(WORLD_TYPE, '1'))
    good = item('b', ADD, 1.0, ObjectType(WORLD_TYPE, '1'))
    with pytest.raises(Exception, match='no shape'):
        story.ownership.apply(SceneUpdate(objects=(wrong, good)))
    assert story.heights() == {'b': 1.0}


@pytest.mark.parametrize('seed', range(4))
def test_random_edits_of_both_sides_end_as_the_rules_say(story, seed):
    """A thousand edits in four runs, against the rules written down a second time."""
    chance, names = random.Random(seed), ['a', 'b', 'c', 'd']
    world, mine, owner, height = {}, {}, {}, 1.0
    for _ in range(250):
        name, height = chance.choice(names), round(height + 0.001, 6)
        step = chance.choice(['spawn', 'delete', 'move', 'add', 'add', 'remove', 'reset', 'again'])
        if step == 'spawn' and name not in world:
            world[name] = height
            story.world((name, ADD, height))
            if name not in mine:
                owner[name] = 'world'
        elif step == 'delete' and name in world:
            del world[name]
            story.world((name, REMOVE, 0.0))
            owner.pop(name, None)
        elif step == 'move' and name in world:
            world[name] = height
            story.world((name, MOVE, height))
        elif step == 'add':
            story.user(name, ADD, height)
            mine[name] = height
            if owner.get(name) in ('world', 'gone'):
                owner[name] = 'taken'
        elif step == 'remove' and name in story.scene.objects:
            story.user(name, REMOVE)
            mine.pop(name, None)
            if owner.get(name) in ('world', 'taken'):
                owner[name] = 'gone'
        elif step in ('reset', 'again') and world:
            story.epoch = str(int(story.epoch) + (step == 'reset'))
            if step == 'reset':
                for one, state in list(owner.items()):
                    if state in ('taken', 'gone'):
                        mine.pop(one, None)
                        owner[one] = 'world'
            for one in world:
                if one not in owner and one not in mine:
                    owner[one] = 'world'
            story.world(*((one, ADD, at) for one, at in world.items()))
        expected = {**mine, **{one: world[one] for one, state in owner.items()
                               if state == 'world'}}
        assert story.heights() == pytest.approx(expected)
    assert np.isfinite(height)


def test_objects_that_cannot_be_had_are_named_and_the_others_are_there(story):
    """What a message of the world refuses is reported; its other objects are added."""
    kind = ObjectType(WORLD_TYPE, '1')
    with pytest.raises(PlanningError, match=r'2 parts.*unreadable.*no shape'):
        story.ownership.apply(SceneUpdate(
            objects=(CollisionObject('flat', type=kind), item('a', ADD, 1.0, kind)),
            unreadable=(PlanningError(-19, 'unreadable'),)))
    assert set(story.scene.objects) == {'a'}
    assert not of_world(SceneUpdate(objects=(item('a', ADD, 1.0, kind),), replaces_world=True))
