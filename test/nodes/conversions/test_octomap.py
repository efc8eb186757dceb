# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Octomaps as messages, and which messages change the map of a scene."""

import numpy as np
from octomap_msgs.msg import OctomapWithPose
import pytest
from small_arms import planar_arm

from armsim_ros.errors import PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.nodes.conversions.octomap import octomap_to_message
from armsim_ros.nodes.conversions.planning_scene import (
    Component,
    scene_to_message,
    update_from_message,
    world_from_message,
)
from armsim_ros.planning.scene.octomap import octomap_from_cells
from armsim_ros.planning.scene.octree_data import write_binary
from armsim_ros.planning.scene.planning_scene import PlanningScene


@pytest.fixture
def scene():
    """Return a scene with a map."""
    made = PlanningScene(KinematicModel(planar_arm()))
    made.set_octomap(octomap_from_cells(
        np.array([[4, 0, 0], [5, 5, 1], [9, 9, 9]]), np.array([0.85, 3.5, -2.0], dtype=np.float32),
        0.05, np.eye(4)))
    return made


def sent(scene, *, diff=True, **parts):
    """Return the message of a scene with other values in its map."""
    message = scene_to_message(scene, Component.OCTOMAP)
    message.is_diff = message.robot_state.is_diff = diff
    for name, value in parts.items():
        setattr(message.world.octomap.octomap, name, value)
    return message


def take(scene, message):
    """Return the map of another scene that takes a message."""
    other = scene.snapshot()
    try:
        other.apply(update_from_message(message, other.model_frame))
    except PlanningError as error:
        return other.octomap, str(error)
    return other.octomap, ''


def cells(octomap):
    """Return centres and edges of the occupied leaves."""
    return [np.round(part, 6).tolist() for part in octomap.boxes]


def test_map_goes_through_a_message(scene):
    """The full form has id, resolution, frame and log odds."""
    message = sent(scene)
    tree = message.world.octomap.octomap
    assert (tree.id, tree.binary, tree.resolution) == ('OcTree', False, 0.05)
    assert message.world.octomap.header.frame_id == scene.model_frame
    assert message.world.octomap.origin.orientation.w == 1.0
    made, error = take(scene, message)
    assert not error
    assert made is not scene.octomap
    assert cells(made) == cells(scene.octomap)
    assert sorted(made.leaves.log_odds) == sorted(scene.octomap.leaves.log_odds)


def test_binary_form_is_read(scene):
    """Clients send two bits for a child."""
    data = list(np.frombuffer(write_binary(scene.octomap.leaves)[0], dtype=np.int8))
    made, error = take(scene, sent(scene, binary=True, data=data))
    assert not error
    assert cells(made) == cells(scene.octomap)


def test_origin_counts_in_the_frame_of_the_header(scene):
    """The pose is that of the frame times the origin."""
    message = sent(scene)
    message.world.octomap.header.frame_id = 'tool'
    message.world.octomap.origin.position.x = 0.25
    made, _ = take(scene, message)
    assert np.allclose(made.pose, scene.frame_pose('tool') @ pose_matrix((0.25, 0, 0)))


@pytest.mark.parametrize(('diff', 'parts', 'left'), [
    (True, {'id': ''}, True),
    (True, {'id': '', 'data': []}, True),
    (True, {'data': []}, False),
    (True, {'id': 'cleared', 'data': []}, False),
    (False, {'id': '', 'data': []}, False),
    (False, {}, True),
])
def test_messages_without_data(scene, diff, parts, left):
    """
    A diff without an id changes nothing; without data the map goes.

    moveit_core planning_scene.cpp, setPlanningSceneDiffMsg and processOctomapMsg.
    """
    octomap, error = take(scene, sent(scene, diff=diff, **parts))
    assert not error
    assert (octomap is not None) == left


def test_world_message_replaces_the_map(scene):
    """A planning_scene_world message has the whole world, its map as well."""
    message = sent(scene).world
    scene.apply(world_from_message(message))
    assert scene.octomap is not None
    message.octomap = OctomapWithPose()
    scene.apply(world_from_message(message))
    assert scene.octomap is None


@pytest.mark.parametrize(('parts', 'text', 'left'), [
    ({'id': 'ColorOcTree'}, "class 'ColorOcTree'", False),
    ({'resolution': 0.0}, 'resolution is 0.0 m', True),
    ({'data': [1, 2, 3]}, 'has 3 bytes and ends in the middle', True),
    ({'binary': True, 'data': [3, 0]}, 'ends at byte 2', True),
])
def test_bad_map_is_one_sentence(scene, parts, text, left):
    """A tree of another class takes the map away, other faults leave it as it was."""
    octomap, error = take(scene, sent(scene, **parts))
    assert text in error
    assert (octomap is scene.octomap) == left
    assert (octomap is None) != left


def test_unknown_frame_leaves_the_map(scene):
    """The sentence names the frame."""
    message = sent(scene)
    message.world.octomap.header.frame_id = 'nowhere'
    octomap, error = take(scene, message)
    assert octomap is scene.octomap
    assert "'nowhere'" in error


def test_no_map_is_a_message_without_data(scene):
    """Only the frame is there."""
    message = octomap_to_message(None, 'world')
    assert not message.octomap.data
    assert (message.octomap.id, message.header.frame_id) == ('', 'world')
