# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Frames of TF in the planning scene."""

from geometry_msgs.msg import TransformStamped
import numpy as np
import pytest
from small_arms import planar_arm
from tf2_msgs.msg import TFMessage

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.nodes.conversions.planning_scene import scene_to_message, update_from_message
from armsim_ros.nodes.move_group.scene.transforms import Transforms
from armsim_ros.planning.scene.planning_scene import PlanningScene


class Host:
    """A program whose topics a test fills."""

    def __init__(self):
        self.scene = PlanningScene(KinematicModel(planar_arm()))
        self.robot, self.receive = self.scene.kinematic_model.robot, {}

    def subscribe(self, kind, name, receive, profile):
        self.receive[name] = receive

    def publish(self, parent, child):
        transform = TransformStamped(child_frame_id=child)
        transform.header.frame_id = parent
        transform.transform.translation.x = 0.1
        self.receive['/tf_static'](TFMessage(transforms=[transform]))


@pytest.fixture
def host():
    """Return a program that follows the static frames of TF."""
    host = Host()
    Transforms(host, moving=False)
    return host


def test_a_static_frame_stays_on_its_link_when_the_full_scene_is_applied(host):
    """
    A client that edits a scene it has requested, and applies it, does not move frames of TF.

    moveit_ros planning_scene_monitor.cpp, updateFrameTransforms.
    """
    scene = host.scene
    host.publish('tool', 'camera')
    scene.apply(update_from_message(scene_to_message(scene), scene.model_frame))
    scene.set_positions({'axis1': np.pi / 2})
    np.testing.assert_allclose(
        scene.frame_pose('camera')[:3, 3], (scene.frame_pose('tool') @ (0.1, 0, 0, 1))[:3])
