# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Scenes and their objects as messages, as those take them over who follow."""

import contextlib

from geometry_msgs.msg import TransformStamped
from hypothesis import given, settings
from hypothesis import strategies as st
from moveit_msgs.msg import (
    AttachedCollisionObject,
    LinkPadding,
    LinkScale,
    ObjectColor,
    RobotState,
)
from moveit_msgs.msg import CollisionObject as CollisionObjectMessage
from moveit_msgs.msg import PlanningScene as PlanningSceneMessage
import numpy as np
import pytest
from scene_summary import summary
from small_arms import planar_arm

from armsim_ros.errors import PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Box, Mesh, Plane, Sphere
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.nodes.conversions.collision_object import object_from_message, object_to_message
from armsim_ros.nodes.conversions.geometry import pose_to_message
from armsim_ros.nodes.conversions.motion_plan_request import start_state_from_message
from armsim_ros.nodes.conversions.planning_scene import (
    is_empty,
    scene_to_message,
    update_from_message,
)
from armsim_ros.nodes.move_group.scene.scene_topics import fill_geometry
from armsim_ros.planning.scene.objects import (
    AttachedObject,
    CollisionObject,
    ObjectOperation,
    ObjectShape,
)
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import SceneUpdate

ADD, REMOVE, APPEND, MOVE = ObjectOperation
BALL = (ObjectShape(Sphere(0.1)),)

IDS = st.sampled_from(['a', 'b', 'c'])
POSES = st.tuples(*[st.floats(-1, 1)] * 3).map(pose_matrix)
EDITS = st.one_of(
    st.builds(lambda i, p: CollisionObject(i, ADD, pose=p, shapes=BALL), IDS, POSES),
    st.builds(lambda i, p: CollisionObject(i, MOVE, pose=p), IDS, POSES),
    st.builds(lambda i, p: CollisionObject(
        i, APPEND, 'segment2', p, (ObjectShape(Box((0.1, 0.1, 0.1))),)), IDS, POSES),
    st.builds(lambda i: CollisionObject(i, REMOVE), IDS),
    st.builds(lambda i, k: AttachedObject(k, CollisionObject(i)),
              IDS, st.sampled_from(['segment1', 'tool'])),
    st.builds(lambda i: AttachedObject('', CollisionObject(i, REMOVE)), IDS),
    st.builds(lambda i: SceneUpdate(object_colors={i: (1.0, 0.0, 0.0, 1.0)}), IDS),
)


@pytest.fixture(scope='module')
def kinematics():
    """Return a planar arm."""
    return KinematicModel(planar_arm())


def edit(scene, what):
    """Apply an edit; a refused one is no edit."""
    apply = scene.apply
    if isinstance(what, CollisionObject):
        apply = scene.apply_object
    elif isinstance(what, AttachedObject):
        apply = scene.apply_attached
    with contextlib.suppress(PlanningError):
        apply(what)


def follower_of(scene, kinematics):
    """Return a scene that took over all that another one holds."""
    copy = PlanningScene(kinematics)
    copy.apply(update_from_message(scene_to_message(scene), scene.model_frame))
    return copy


def same(one, other, *parts):
    """Return whether two scenes hold the same in some parts."""
    first, second = summary(one.content), summary(other.content)
    return all(first[part] == second[part] for part in parts)


@settings(max_examples=60, deadline=None)
@given(first=st.lists(EDITS, max_size=6), second=st.lists(EDITS, max_size=6))
def test_difference_leads_from_one_scene_to_the_next(kinematics, first, second):
    """IF-40a: a follower that applies the differences holds the same scene."""
    scene = PlanningScene(kinematics)
    for what in first:
        edit(scene, what)
    follower, before = follower_of(scene, kinematics), scene.snapshot()
    for what in second:
        edit(scene, what)
    message = PlanningSceneMessage(is_diff=True)
    message.robot_state.is_diff = True
    fill_geometry(message, before, scene)
    follower.apply(update_from_message(message, scene.model_frame))
    assert same(scene, follower, 'objects', 'attached', 'acm')


def test_whole_scene_makes_the_same_scene(kinematics):
    """SRV-50, MGI-7: what a client gets is all that there is, and it can be sent back."""
    scene = PlanningScene(kinematics)
    triangle = Mesh(np.eye(3), np.array([[0, 1, 2]]))
    scene.apply_object(CollisionObject(
        'mixed', pose=pose_matrix((0, 1, 0), (0.1, 0.2, 0.3)),
        shapes=(ObjectShape(Box((1.0, 2.0, 3.0))), ObjectShape(triangle, pose_matrix((0, 0, 1))),
                ObjectShape(Plane(0.0, 0.0, 1.0, 0.5))),
        subframes={'top': pose_matrix((0, 0, 1))}))
    held = CollisionObject('held', frame_id='tool', shapes=BALL)
    scene.apply_attached(AttachedObject('tool', held, ('segment3',), weight=0.25))
    scene.apply(SceneUpdate(link_padding={'segment1': 0.5}, link_scale={'segment2': 1.5},
                            object_colors={'mixed': (0.25, 0.5, 0.75, 1.0)}))
    scene.set_positions({'axis1': 0.4})
    assert same(scene, follower_of(scene, kinematics),
                'q', 'objects', 'attached', 'acm', 'padding', 'scale', 'colors')


def test_a_fixed_transform_leads_to_the_model_frame(kinematics):
    """
    The frame's name is header.frame_id, the model frame child_frame_id; others are refused.

    moveit_core transforms.cpp, setTransform and copyTransforms.
    """
    scene = PlanningScene(kinematics)
    message = PlanningSceneMessage(is_diff=True)
    for frame, target in (('table', scene.model_frame), ('lamp', 'table'), ('', 'world')):
        message.fixed_frame_transforms.append(TransformStamped(child_frame_id=target))
        message.fixed_frame_transforms[-1].header.frame_id = frame
        message.fixed_frame_transforms[-1].transform.translation.x = 2.0
    with pytest.raises(PlanningError, match=r"2 parts.*'lamp'"):
        scene.apply(update_from_message(message, scene.model_frame))
    assert scene.frame_pose('table')[0, 3] == 2.0
    assert not scene.has_frame('lamp')
    told = scene_to_message(scene).fixed_frame_transforms
    assert [(one.header.frame_id, one.child_frame_id) for one in told] == [
        (scene.model_frame, scene.model_frame), ('table', scene.model_frame)]


def test_an_object_that_cannot_be_read_is_named_and_the_others_are_added(kinematics):
    """
    A shape without size or with too many poses refuses its object alone.

    moveit_core planning_scene.cpp, setPlanningSceneDiffMsg.
    """
    scene = PlanningScene(kinematics)
    message = PlanningSceneMessage(is_diff=True)
    message.world.collision_objects = [
        object_to_message(CollisionObject(name, shapes=BALL), '') for name in ('a', 'b', 'c')]
    message.world.collision_objects[0].primitives[0].dimensions = [0.0]
    message.world.collision_objects[1].pose.position.x = float('nan')
    with pytest.raises(PlanningError, match=r"2 parts.*'a'.*'b'"):
        scene.apply(update_from_message(message, scene.model_frame))
    assert set(scene.objects) == {'c'}


def filled(part, value):
    """Return a message without content but for one part."""
    message = PlanningSceneMessage()
    message.robot_state.is_diff = True
    *path, last = part.split('.')
    holder = message
    for name in path:
        holder = getattr(holder, name)
    setattr(holder, last, value)
    return message


@pytest.mark.parametrize(('part', 'value', 'empty'), [
    ('is_diff', True, True),
    ('object_colors', [ObjectColor(id='a')], True),
    ('robot_state.is_diff', False, False),
    ('robot_state.joint_state.header.frame_id', 'a', True),
    ('robot_state.joint_state.effort', [1.0], False),
    ('robot_state.multi_dof_joint_state.joint_names', ['a'], False),
    ('robot_state.attached_collision_objects', [AttachedCollisionObject()], False),
    ('name', 'a', False),
    ('fixed_frame_transforms', [TransformStamped()], False),
    ('allowed_collision_matrix.entry_names', ['a'], False),
    ('allowed_collision_matrix.default_entry_names', ['a'], True),
    ('link_padding', [LinkPadding()], False),
    ('link_scale', [LinkScale()], False),
    ('world.collision_objects', [CollisionObjectMessage()], False),
    ('world.octomap.octomap.data', [1], False),
])
def test_a_message_without_content(part, value, empty):
    """
    A default-constructed message has robot_state.is_diff false, and so some content.

    moveit_core message_checks.cpp, isEmpty.
    """
    assert is_empty(filled(part, value)) == empty


def test_attached_objects_of_a_start_state_need_a_pose_for_each_shape():
    """
    What has none is refused for a start state, and has the identity in a scene message.

    moveit_core conversions.cpp, msgToAttachedBody; planning_scene.cpp.
    """
    item = AttachedCollisionObject(link_name='tool', object=object_to_message(
        CollisionObject('held', shapes=BALL), 'tool'))
    state = RobotState(is_diff=True, attached_collision_objects=[item])
    assert not start_state_from_message(state).unreadable
    item.object.primitive_poses = []
    assert "'held'" in str(start_state_from_message(state).unreadable[0])
    scene = PlanningSceneMessage(is_diff=True, robot_state=state)
    assert len(update_from_message(scene, 'world').robot_state.attached_objects) == 1


def test_more_poses_than_shapes_are_refused():
    """SCN-2: a pose without a shape is a mistake of the client's; a missing pose is none."""
    two = (ObjectShape(Sphere(0.1), pose_matrix((1, 0, 0))), ObjectShape(Sphere(0.2)))
    message = object_to_message(CollisionObject('two', shapes=two), 'world')
    message.primitive_poses.pop()
    shapes = object_from_message(message).shapes
    np.testing.assert_array_equal(shapes[0].pose, pose_matrix((1, 0, 0)))
    np.testing.assert_array_equal(shapes[1].pose, np.eye(4))
    message.primitive_poses = [pose_to_message(np.eye(4))] * 3
    with pytest.raises(PlanningError, match="'two': 3 poses are given for 2 shapes"):
        object_from_message(message)


def test_move_gives_poses_alone():
    """SCN-6: a MOVE has no shapes; its poses are those of primitives, meshes and planes."""
    message = CollisionObjectMessage(id='two', operation=CollisionObjectMessage.MOVE)
    message.mesh_poses = [pose_to_message(pose_matrix((0, 0, 1)))]
    item = object_from_message(message)
    assert not item.shapes
    assert len(item.shape_poses) == 1
