# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where frames are in the scene of a request, which has a robot state and objects of its own."""

import numpy as np
import pytest

from armsim_ros.errors import PlanningError
from armsim_ros.model.geometry import Sphere
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.scene.content import FixedFrame, further_frames
from armsim_ros.planning.scene.objects import CollisionObject, ObjectOperation, ObjectShape
from armsim_ros.planning.scene.update import SceneUpdate, StartState


def test_a_start_state_moves_no_frame_of_tf(scene):
    """
    A frame that rides on a link is where it is now, whatever state a request starts in.

    Upstream: planning_scene_monitor.cpp, updateFrameTransforms, fixes the frames of TF at present.
    """
    scene.set_frames({'camera': FixedFrame('fore', pose_matrix((0.1, 0.0, 0.0)))})
    now = scene.frame_pose('camera')
    start = StartState.from_positions({'shoulder': 0.5})
    for request in (scene.with_start_state(start), scene.with_update(
            SceneUpdate(robot_state=start, is_diff=True))):
        assert request.kinematic_model.positions(request.q)['shoulder'] == 0.5
        assert np.allclose(request.frame_pose('camera'), now)
    scene.set_positions({'shoulder': 0.5})
    assert not np.allclose(scene.frame_pose('camera'), now)


def test_a_request_evaluates_no_frame_that_it_does_not_name(scene):
    """Frames of TF are kept as they are until their pose is needed, however many there are."""
    scene.set_frames({'camera': FixedFrame('fore', pose_matrix((0.1, 0.0, 0.0)))})
    for request in (scene.with_start_state(StartState()), scene.with_update(SceneUpdate())):
        assert request.content.standing is scene.content
        assert further_frames(request.content) == further_frames(scene.content)


def test_a_frame_of_a_request_overrides_tf(scene):
    """
    A fixed frame in a request's scene is where the request has it; TF has the others.

    Upstream: planning_scene.cpp, setPlanningSceneDiffMsg.
    """
    scene.set_frames({
        'camera': FixedFrame('fore', pose_matrix((0.1, 0.0, 0.0))),
        'lens': FixedFrame('camera', np.eye(4)),
    })
    lens = scene.frame_pose('lens')
    request = scene.with_update(SceneUpdate(fixed_frames={'camera': pose_matrix((0, 2, 0))}))
    np.testing.assert_allclose(request.frame_pose('camera')[:3, 3], (0, 2, 0), atol=1e-12)
    np.testing.assert_allclose(request.frame_pose('lens'), lens, atol=1e-12)


def test_objects_of_a_request_move_no_frame_of_tf(scene):
    """A frame that is fixed to an object is where the object was when the request came."""
    scene.apply_object(CollisionObject(
        'ball', shapes=(ObjectShape(Sphere(0.1), pose_matrix((1.0, 0.0, 0.0))),)))
    scene.set_frames({'mark': FixedFrame('ball', np.eye(4))})
    mark = scene.frame_pose('mark')
    moved = CollisionObject('ball', ObjectOperation.MOVE, pose=pose_matrix((0, 1, 0)))
    gone = CollisionObject('ball', ObjectOperation.REMOVE)
    for change in (moved, gone):
        request = scene.with_update(SceneUpdate(objects=(change,)))
        np.testing.assert_allclose(request.frame_pose('mark'), mark, atol=1e-12)
    assert not request.has_frame('ball')


def test_the_error_of_a_request_names_the_chain_of_transforms(scene):
    """A frame of TF that leads to no link is refused as in the scene itself."""
    scene.set_frames({'a': FixedFrame('map', np.eye(4))})
    request = scene.with_start_state(StartState())
    assert not request.has_frame('a')
    with pytest.raises(PlanningError, match="ends at 'map'"):
        request.frame_pose('a')
