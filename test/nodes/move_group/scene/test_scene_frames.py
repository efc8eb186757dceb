# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Frames of the scene's objects on /tf."""

from types import SimpleNamespace

from builtin_interfaces.msg import Time
import numpy as np
import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.config.ompl_planning import PlanningParameters
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Box
from armsim_ros.model.loading import load_robot_model
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.nodes.move_group.scene.scene_services import SceneFrames
from armsim_ros.planning.scene.objects import AttachedObject, CollisionObject, ObjectShape
from armsim_ros.planning.scene.planning_scene import PlanningScene


class Node:
    """What the frames need of a node."""

    def __init__(self):
        self.sent = []

    def get_name(self):
        return 'move_group'

    def create_publisher(self, kind, topic, profile):
        assert topic == '/tf'
        return SimpleNamespace(publish=self.sent.append)

    def create_timer(self, period, callback, clock):
        self.period, self.publish = period, callback

    def get_clock(self):
        return SimpleNamespace(now=lambda: SimpleNamespace(to_msg=lambda: Time(sec=5)))


@pytest.fixture
def published():
    """Return what gives the transforms of a scene with a box, and one in the hand."""
    scene = PlanningScene(KinematicModel(load_robot_model(load_robot_settings('sunday'))))
    for name in ('box', 'tool'):
        scene.apply_object(CollisionObject(
            name, pose=pose_matrix((0.5, 0.1, 1.2)),
            shapes=(ObjectShape(Box((0.1, 0.1, 0.1)), np.eye(4)),),
            subframes={'top': pose_matrix((0, 0, 0.05))}))
    scene.apply_attached(AttachedObject('link_6', CollisionObject('tool')))

    def make(**parameters):
        node = Node()
        frames = SceneFrames(SimpleNamespace(
            node=node, scene=scene, frame=scene.model_frame,
            planning_parameters=PlanningParameters(**parameters)))
        node.publish()
        assert all(len(message.transforms) == 1 for message in node.sent)
        sent = [message.transforms[0] for message in node.sent]
        return frames, node, {each.child_frame_id: each for each in sent}

    return make


def test_objects_and_subframes(published):
    """
    Each has a frame in the planning frame, or on the link that carries it; subframes are in it.

    moveit_ros tf_publisher_capability.cpp.
    """
    _, node, transforms = published()
    assert node.period == pytest.approx(0.1)
    assert set(transforms) == {
        'move_group/box', 'move_group/box/top', 'move_group/tool', 'move_group/tool/top',
    }
    box = transforms['move_group/box']
    assert box.header.frame_id == 'world'
    assert box.transform.translation.z == pytest.approx(1.2)
    top = transforms['move_group/box/top']
    assert top.header.frame_id == 'move_group/box'
    assert top.transform.translation.z == pytest.approx(0.05)
    assert transforms['move_group/tool'].header.frame_id == 'link_6'
    assert transforms['move_group/tool/top'].header.frame_id == 'move_group/tool'


@pytest.mark.parametrize(('prefix', 'name'), [('scene', 'scene/box'), ('', 'box')])
def test_prefix(published, prefix, name):
    """The prefix is the parameter's, '' for none."""
    _, _, transforms = published(planning_scene_tf_prefix=prefix)
    assert name in transforms


def test_rate(published):
    """Each frame is published as often as the parameter says."""
    _, node, _ = published(planning_scene_frame_publishing_rate=50)
    assert node.period == pytest.approx(0.02)
