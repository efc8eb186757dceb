# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What holds for any scene messages."""

from hypothesis import given, settings
from hypothesis import strategies as st
from scene_summary import summary

from armsim_ros.errors import PlanningError
from armsim_ros.model.geometry import Sphere
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.scene.objects import (
    AttachedObject,
    CollisionObject,
    ObjectOperation,
    ObjectShape,
)
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import SceneUpdate, StartState

ADD, REMOVE, APPEND, MOVE = ObjectOperation


def ball(id_='ball', at=(1.0, 0.0, 0.0)):
    """Return an update that adds a sphere."""
    return CollisionObject(id_, shapes=(ObjectShape(Sphere(0.1), pose_matrix(at)),))


def held(id_):
    """Return an update that attaches a sphere at the origin of a link."""
    item = CollisionObject(id_, frame_id='fore', shapes=(ObjectShape(Sphere(0.02)),))
    return AttachedObject('fore', item)


def removed(id_):
    """Return an update that removes an object."""
    return CollisionObject(id_, REMOVE)


def detached(id_):
    """Return an update that detaches an object."""
    return AttachedObject('', CollisionObject(id_, REMOVE))


IDS = st.sampled_from(['a', 'b', 'c'])
POSES = st.tuples(*[st.floats(-1, 1)] * 3).map(pose_matrix)
OBJECTS = st.one_of(
    st.builds(lambda i, p: CollisionObject(i, ADD, pose=p, shapes=ball().shapes), IDS, POSES),
    st.builds(lambda i, p: CollisionObject(i, APPEND, pose=p, shapes=ball().shapes), IDS, POSES),
    st.builds(lambda i, p: CollisionObject(i, MOVE, pose=p), IDS, POSES),
    st.builds(lambda i: CollisionObject(i, REMOVE), IDS),
    st.builds(lambda i: CollisionObject(i, ADD, 'nowhere', shapes=ball().shapes), IDS),
    st.builds(lambda i: CollisionObject(i, ADD), IDS),
)
ATTACHED = st.one_of(
    st.builds(held, IDS),
    st.builds(lambda i: AttachedObject('tool', CollisionObject(i)), IDS),
    st.builds(lambda i: AttachedObject('nose', ball(i)), IDS),
    st.builds(detached, IDS),
)
PARTS = st.one_of(
    OBJECTS.map(lambda item: SceneUpdate(objects=(item,))),
    ATTACHED.map(lambda item: SceneUpdate(robot_state=StartState(attached_objects=(item,)))),
    st.builds(lambda link, value: SceneUpdate(link_padding={link: value}),
              st.sampled_from(['fore', 'nose']), st.floats(-0.1, 0.1)),
)


@settings(max_examples=80, deadline=None)
@given(parts=st.lists(PARTS, max_size=8))
def test_a_refused_part_leaves_the_content_as_it_was(kinematics, parts):
    """Whatever the scene holds, a message of a single part changes it or is refused."""
    scene = PlanningScene(kinematics)
    for part in parts:
        before = summary(scene.content)
        try:
            scene.apply(part)
        except PlanningError:
            assert summary(scene.content) == before


@settings(max_examples=80, deadline=None)
@given(objects=st.lists(OBJECTS, max_size=6), attached=st.lists(ATTACHED, max_size=4))
def test_a_message_is_the_sum_of_its_parts(kinematics, objects, attached):
    """A message of many parts leads to the scene to which its parts lead one after the other."""
    whole, single = PlanningScene(kinematics), PlanningScene(kinematics)
    refused = []
    for update in [
        *(SceneUpdate(robot_state=StartState(attached_objects=(item,))) for item in attached),
        *(SceneUpdate(objects=(item,)) for item in objects),
    ]:
        try:
            single.apply(update)
        except PlanningError as error:
            refused.append(str(error))
    whole = whole.with_update(SceneUpdate(
        objects=tuple(objects), robot_state=StartState(attached_objects=tuple(attached))))
    assert summary(whole.content) == summary(single.content)
    assert [str(error) for error in whole.refusals] == refused


@settings(max_examples=60, deadline=None)
@given(objects=st.lists(OBJECTS, max_size=6), pose=POSES, angle=st.floats(-3.0, 3.0))
def test_an_edit_and_its_inverse_change_nothing(kinematics, objects, pose, angle):
    """Add and remove, move and move back, attach and detach bring the scene back."""
    scene = PlanningScene(kinematics).with_update(SceneUpdate(objects=tuple(objects)))
    scene.set_positions({'shoulder': angle})
    scene.apply_object(ball('known', (2.0, 0.0, 0.0)))
    before = summary(scene.content)
    scene.apply_object(ball('other', pose[:3, 3]))
    scene.apply_object(removed('other'))
    scene.apply_object(CollisionObject('known', MOVE, pose=pose))
    scene.apply_object(CollisionObject('known', MOVE, pose=pose_matrix((2.0, 0.0, 0.0))))
    scene.apply_attached(AttachedObject('fore', CollisionObject('known')))
    scene.apply_attached(detached('known'))
    after = summary(scene.content)
    assert after.keys() == before.keys()
    assert after == before
