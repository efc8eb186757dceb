# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Frames of TF in the planning scene."""

from dataclasses import replace

from geometry_msgs.msg import TransformStamped
import numpy as np
import pytest
from small_arms import planar_arm
from tf2_msgs.msg import TFMessage

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.semantic_model import VirtualJoint
from armsim_ros.nodes.conversions.planning_scene import scene_to_message, update_from_message
from armsim_ros.nodes.move_group.scene.transforms import Transforms
from armsim_ros.planning.scene.planning_scene import PlanningScene


class Host:
    """A program whose topics a test fills."""

    def __init__(self, robot):
        self.scene = PlanningScene(KinematicModel(robot))
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
    host = Host(planar_arm())
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


@pytest.fixture
def tied_host():
    """Return the same, of a robot that a fixed virtual joint ties to the frame world."""
    robot = planar_arm()
    joint = VirtualJoint('tie', 'fixed', 'world', robot.root_link)
    host = Host(replace(robot, semantic=replace(robot.semantic, virtual_joint=joint)))
    Transforms(host, moving=False)
    return host


def test_the_frame_of_a_fixed_virtual_joint_is_where_tf_has_it(tied_host):
    """
    A pedestal between world and root link counts.

    moveit_core robot_model.cpp (constructJointModel): the model frame is the root link;
    planning_scene_monitor.cpp (getUpdatedFrameTransforms).
    """
    tied_host.publish('world', tied_host.robot.root_link)
    assert tied_host.scene.frame_pose('world')[:3, 3] == pytest.approx((-0.1, 0.0, 0.0))


def test_a_chain_above_the_root_leads_to_the_frame_of_a_virtual_joint(tied_host):
    """The pedestal may be a frame of its own."""
    tied_host.publish('pedestal', tied_host.robot.root_link)
    tied_host.publish('world', 'pedestal')
    assert tied_host.scene.frame_pose('world')[:3, 3] == pytest.approx((-0.2, 0.0, 0.0))


def test_the_frame_of_a_fixed_virtual_joint_is_known_without_tf(tied_host):
    """Until TF has it, it is the root link's; what TF hangs on it is known as well."""
    tied_host.publish('world', 'table')
    assert tied_host.scene.frame_pose('world') == pytest.approx(np.eye(4))
    assert tied_host.scene.frame_pose('table')[:3, 3] == pytest.approx((0.1, 0.0, 0.0))
