# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Frames, states, listeners, threads."""

import threading

import numpy as np
import pytest

from armsim_ros.errors import PlanningError
from armsim_ros.model.geometry import Mesh, Sphere
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.scene.content import FixedFrame
from armsim_ros.planning.scene.objects import (
    AttachedObject,
    CollisionObject,
    ObjectOperation,
    ObjectShape,
)
from armsim_ros.planning.scene.update import SceneUpdate, StartState

ADD, REMOVE, APPEND, MOVE = ObjectOperation


def ball(id_='ball', at=(1.0, 0.0, 0.0), **changes):
    """Return an update that adds a sphere."""
    return CollisionObject(id_, shapes=(ObjectShape(Sphere(0.1), pose_matrix(at)),), **changes)


def held(id_='held', link='fore', **changes):
    """Return an update that attaches a sphere at the origin of a link."""
    item = CollisionObject(id_, frame_id=link, shapes=(ObjectShape(Sphere(0.02)),))
    return AttachedObject(link, item, **changes)


# ---------------------------------------------------------------- frames


def test_frames_of_all_kinds_are_found(scene):
    """CON-5: links, world objects, attached objects, subframes and fixed frames."""
    scene.apply_object(ball(subframes={'a/b': pose_matrix((0, 0, 0.1))}))
    scene.apply_attached(held())
    scene.apply(SceneUpdate(fixed_frames={'/camera': pose_matrix((0, 2, 0))}))
    expected = {
        '': (0, 0, 0), 'world': (0, 0, 0), 'base': (0, 0, 0), 'tool': (0.8, 0, 0),
        'ball': (1, 0, 0), 'ball/a/b': (1, 0, 0.1), 'held': (0.4, 0, 0), 'camera': (0, 2, 0),
        '/tool': (0.8, 0, 0),
    }
    for frame, xyz in expected.items():
        np.testing.assert_allclose(scene.frame_pose(frame)[:3, 3], xyz, atol=1e-12)


def test_a_frame_on_a_link_is_looked_up_when_it_is_used(scene):
    """CON-5: objects and goals are where the frame is then; afterwards they stay there."""
    scene.set_frames({
        'lens': FixedFrame('camera', pose_matrix((0.1, 0, 0))),
        'camera': FixedFrame('/tool', pose_matrix((0, 0, 0.2))),
    })
    np.testing.assert_allclose(scene.frame_pose('lens')[:3, 3], (0.9, 0, 0.2), atol=1e-12)
    scene.apply_object(CollisionObject(
        'seen', frame_id='lens', shapes=(ObjectShape(Sphere(0.1)),)))
    scene.set_positions({'shoulder': np.pi / 2})
    np.testing.assert_allclose(scene.frame_pose('lens')[:3, 3], (0, 0.9, 0.2), atol=1e-12)
    link, offset = scene.link_of_frame('lens')
    assert link == 'base'
    np.testing.assert_allclose(offset[:3, 3], (0, 0.9, 0.2), atol=1e-12)
    np.testing.assert_allclose(scene.frame_pose('seen')[:3, 3], (0.9, 0, 0.2), atol=1e-12)


@pytest.mark.parametrize(('frames', 'text'), [
    ({'a': FixedFrame('b', np.eye(4)), 'b': FixedFrame('a', np.eye(4))}, 'circle'),
    ({'a': FixedFrame('map', np.eye(4))}, "ends at 'map'"),
])
def test_a_frame_that_leads_nowhere_is_unknown(scene, frames, text):
    """CON-5: the error tells how far the chain of transforms goes."""
    scene.set_frames(frames)
    assert not scene.has_frame('a')
    with pytest.raises(PlanningError, match=text):
        scene.frame_pose('a')


def test_tf_overrides_the_fixed_frames_of_messages(scene):
    """
    A frame that TF connects to the robot is where TF has it, whatever a scene message says.

    moveit_ros planning_scene_monitor.cpp, updateFrameTransforms.
    """
    scene.set_frames({'camera': FixedFrame('tool', np.eye(4))})
    scene.apply(SceneUpdate(fixed_frames={'camera': pose_matrix((0, 2, 0))}))
    scene.set_positions({'shoulder': np.pi / 2})
    np.testing.assert_allclose(scene.frame_pose('camera')[:3, 3], (0, 0.8, 0), atol=1e-12)


def test_a_fixed_frame_of_a_message_connects_frames_of_tf(scene):
    """
    Where TF leads to no link, the pose of the message counts, for what is fixed to it as well.

    moveit_ros planning_scene_monitor.cpp, getUpdatedFrameTransforms skips such frames.
    """
    scene.set_frames({
        'lens': FixedFrame('camera', pose_matrix((0.1, 0, 0))),
        'camera': FixedFrame('map', np.eye(4)),
    })
    scene.apply(SceneUpdate(fixed_frames={'camera': pose_matrix((0, 2, 0))}))
    np.testing.assert_allclose(scene.frame_pose('camera')[:3, 3], (0, 2, 0), atol=1e-12)
    np.testing.assert_allclose(scene.frame_pose('lens')[:3, 3], (0.1, 2, 0), atol=1e-12)


def test_unknown_frame_is_refused_with_a_hint(scene):
    """SRV-4: code -21 and the nearest known frame."""
    scene.apply_object(ball())
    with pytest.raises(PlanningError, match="did you mean 'ball'") as caught:
        scene.frame_pose('bal')
    assert caught.value.code == -21
    assert not scene.has_frame('bal')


def test_frame_belongs_to_the_link_that_carries_it(scene):
    """CON-7: a frame on an attached object is a fixed offset from its link."""
    scene.apply_attached(held())
    link, offset = scene.link_of_frame('held')
    assert link == 'fore'
    np.testing.assert_allclose(offset, np.eye(4), atol=1e-12)


def test_frames_follow_the_given_state(scene, kinematics):
    """The pose is that of the state asked for, not of the scene's."""
    q = kinematics.vector({'shoulder': np.pi / 2})
    np.testing.assert_allclose(scene.frame_pose('tool', q)[:3, 3], (0, 0.8, 0), atol=1e-12)


# ---------------------------------------------------------------- states


@pytest.mark.parametrize('state', [
    StartState(('shoulder',), (0.1, 0.2)),
    StartState(('knee',), (0.1,)),
    StartState(('shoulder',), (float('inf'),)),
])
def test_wrong_start_state_is_refused(scene, state):
    """REQ-7e, REQ-7f, E13: sizes that differ, unknown joints and infinite values are -17."""
    with pytest.raises(PlanningError) as caught:
        scene.with_start_state(state)
    assert caught.value.code == -17


def test_start_state_is_laid_over_the_current_one(scene):
    """REQ-7a, REQ-7b: joints that are not named stay; the scene itself does not change."""
    scene.set_positions({'shoulder': 0.3, 'elbow': 0.4})
    overlay = scene.with_start_state(StartState(('elbow',), (1.0,)))
    assert overlay.q[:2].tolist() == [0.3, 1.0]
    assert scene.q[:2].tolist() == [0.3, 0.4]
    assert scene.with_start_state(StartState()).q.tolist() == scene.q.tolist()


@pytest.mark.parametrize(('strict', 'kept'), [(False, {'held'}), (True, set())])
def test_attached_objects_stay_unless_strict(scene, strict, kept):
    """REQ-7c: a state that is no difference drops attached objects only when asked to."""
    scene.apply_attached(held())
    start = StartState(('elbow',), (1.0,), is_diff=False)
    assert set(scene.with_start_state(start, strict=strict).attached) == kept


def test_attached_objects_of_a_start_state_are_attached_there(scene):
    """REQ-7g: their frame is that of the start state; the world stays as it is."""
    scene.apply_object(ball('held', (5.0, 0.0, 0.0)))
    start = StartState(('shoulder',), (np.pi / 2,), attached_objects=(held(link='tool'),))
    overlay = scene.with_start_state(start)
    np.testing.assert_allclose(overlay.frame_pose('held')[:3, 3], (0, 0.8, 0), atol=1e-12)
    assert set(overlay.objects) == {'held'}
    assert not scene.attached


def test_an_attached_object_of_a_start_state_has_the_poses_of_its_message(scene):
    """
    The pose of a single shape stays the shape's: the object and its subframes are at the frame.

    moveit_core conversions.cpp, msgToAttachedBody.
    """
    body = CollisionObject(
        'stick', frame_id='tool', shapes=(ObjectShape(Sphere(0.1), pose_matrix((0.1, 0, 0))),),
        subframes={'tip': pose_matrix((0.2, 0, 0))})
    overlay = scene.with_start_state(StartState(attached_objects=(AttachedObject('tool', body),)))
    np.testing.assert_allclose(overlay.frame_pose('stick')[:3, 3], (0.8, 0, 0), atol=1e-12)
    np.testing.assert_allclose(overlay.frame_pose('stick/tip')[:3, 3], (1.0, 0, 0), atol=1e-12)
    (shape,) = overlay.attached['stick'].object.shapes
    np.testing.assert_allclose(shape.pose, pose_matrix((0.1, 0, 0)))


def test_an_attached_object_can_vanish_for_a_request(scene):
    """
    REMOVE in a start state takes an attached object away; it is not put into the world.

    moveit_core conversions.cpp, msgToAttachedBody.
    """
    scene.apply_attached(held())
    gone = AttachedObject('', CollisionObject('held', REMOVE))
    overlay = scene.with_start_state(StartState(attached_objects=(gone,)))
    assert not overlay.attached
    assert not overlay.objects
    assert set(scene.attached) == {'held'}


@pytest.mark.parametrize('bad', [
    AttachedObject('fore', CollisionObject('ball')),
    AttachedObject('fore', CollisionObject('ghost', REMOVE)),
    held(link='nose'),
    AttachedObject('fore', ball('held', operation=APPEND)),
])
def test_a_start_state_names_attached_objects_that_it_cannot_take(scene, bad):
    """
    ADD needs shapes and REMOVE an attached object; the rest of the start state counts.

    moveit_core conversions.cpp, msgToAttachedBody.
    """
    scene.apply_object(ball())
    overlay = scene.with_start_state(StartState(
        ('elbow',), (1.0,), attached_objects=(bad, held('good'))))
    assert set(overlay.attached) == {'good'}
    assert overlay.q[1] == 1.0
    assert overlay.refused


def test_state_is_read_only(scene):
    """Nobody changes a scene behind its back."""
    with pytest.raises(ValueError):
        scene.q[0] = 1.0


# ---------------------------------------------------------------- listeners and threads


def test_the_robot_moves_on_while_a_long_edit_is_made(scene):
    """Setting the state never waits for an edit, and the edit takes nothing back."""
    sent, waiting = threading.Event(), threading.Event()

    class Slow(dict):
        def items(self):
            waiting.set()
            assert sent.wait(10.0)
            return {'fore': 0.1}.items()

    edit = threading.Thread(target=lambda: scene.apply(SceneUpdate(link_padding=Slow(fore=0.1))))
    edit.start()
    assert waiting.wait(10.0)
    scene.set_positions({'elbow': 0.7})
    scene.set_frames({'cam': FixedFrame('', np.eye(4))})
    sent.set()
    edit.join(10.0)
    assert scene.link_padding['fore'] == 0.1
    assert scene.kinematic_model.positions(scene.q)['elbow'] == 0.7
    assert scene.has_frame('cam')


def test_listener_sees_every_edit_once(scene):
    """A whole message is one edit; a removed listener hears nothing."""
    seen = []
    remove = scene.add_listener(lambda before, after: seen.append((before, after)))
    before = scene.content
    scene.apply(SceneUpdate(objects=(ball('a'), ball('b'))))
    assert seen == [(before, scene.content)]
    remove()
    scene.apply_object(ball('c'))
    assert len(seen) == 1


def test_what_is_in_the_way_of_a_motion(scene):
    """Things and frames decide whether two contents collide alike, the robot's motion does not."""
    start = scene.content
    scene.set_positions({'shoulder': 0.1})
    assert scene.content.collides_like(start)
    scene.apply_object(ball())
    added = scene.content
    assert not added.collides_like(start)
    scene.set_frames({'cam': FixedFrame('', pose_matrix())})
    assert not scene.content.collides_like(added)


def test_snapshot_stays_as_it_was(scene):
    """A snapshot does not see later edits, nor the scene those of the snapshot."""
    scene.apply_object(ball('a'))
    copy = scene.snapshot()
    scene.apply_object(ball('b'))
    copy.apply_object(ball('c'))
    assert set(copy.objects) == {'a', 'c'}
    assert set(scene.objects) == {'a', 'b'}


def test_edits_of_several_threads_are_all_there(scene):
    """No edit is lost when threads edit at once."""
    def work(name):
        for number in range(50):
            scene.apply_object(ball(f'{name}{number}'))

    threads = [threading.Thread(target=work, args=(name,)) for name in 'abcd']
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(scene.objects) == 200


def test_clear_brings_back_the_beginning(scene):
    """Objects and rules go, the state and the frames stay."""
    scene.apply_object(ball())
    scene.apply_attached(held())
    scene.set_acm(scene.acm.with_pair('ball', 'fore', True))
    scene.set_positions({'shoulder': 0.2})
    scene.clear()
    assert not scene.objects
    assert not scene.attached
    assert not scene.acm.allowed('ball', 'fore')
    assert scene.q[0] == 0.2


def test_mesh_is_kept_by_reference(scene, make_mesh):
    """A large mesh is not copied by edits."""
    mesh: Mesh = make_mesh(0.2)
    scene.apply_object(CollisionObject('m', shapes=(ObjectShape(mesh),)))
    scene.apply_object(CollisionObject('m', MOVE, pose=pose_matrix((1, 0, 0))))
    assert scene.objects['m'].shapes[0].geometry is mesh


# ---------------------------------------------------------------- copies to edit


def test_a_copy_is_edited_and_put_in_place_as_a_whole(scene):
    """Its edits are a single edit of the scene; state and frames that came meanwhile stay."""
    contents = []
    scene.add_listener(lambda before, after: contents.append(after))
    with scene.edited() as copy:
        copy.apply_object(ball())
        copy.apply_object(ball('other'))
        copy.set_state(scene.q + 0.1)
        copy.set_state(scene.q)  # tried out, and taken back
        assert not scene.objects
        scene.set_state(scene.q + 0.2)
    assert list(scene.objects) == ['ball', 'other']
    assert scene.q == pytest.approx(scene.kinematic_model.default() + 0.2)
    assert len(contents) == 2
    with scene.edited():
        pass
    assert len(contents) == 2


def test_others_wait_for_the_end_of_an_edit(scene):
    """An edit of another thread comes after it, also where it ends with an exception."""
    thread = threading.Thread(target=lambda: scene.apply_object(ball('theirs')))

    def fail():
        with scene.edited() as copy:
            thread.start()
            copy.apply_object(ball('ours'))
            assert not scene.objects
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    thread.join(5.0)
    assert list(scene.objects) == ['ours', 'theirs']


def test_a_snapshot_with_another_robot_state(scene):
    """State and carried objects are replaced, the world stays; or the world goes."""
    scene.apply_object(ball())
    scene.apply_attached(held())
    bare = scene.with_robot(scene.q + 0.1, {})
    assert not bare.attached
    assert list(bare.objects) == ['ball']
    assert bare.q == pytest.approx(scene.q + 0.1)
    bare.set_attached(scene.attached)
    assert list(bare.attached) == ['held']
    assert not scene.without_world().objects
