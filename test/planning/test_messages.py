# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of what goes between the two planners' processes."""

import os
from types import MappingProxyType

import numpy as np
import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Box, Mesh
from armsim_ros.model.loading import load_robot_model
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.messages import readable, received, send
from armsim_ros.planning.request import Constraints, JointConstraint, MotionPlanRequest
from armsim_ros.planning.scene import PlanningScene
from armsim_ros.planning.scene_update import AttachedObjectUpdate, CollisionObjectUpdate
from armsim_ros.planning.second_attempt import Job
from armsim_ros.planning.settings import settings_from_config


@pytest.fixture
def through(tmp_path):
    """Return a function that writes a message and reads it back."""
    def pass_on(message):
        file = os.open(tmp_path / 'message', os.O_RDWR | os.O_CREAT | os.O_TRUNC)
        try:
            send(file, message)
            os.lseek(file, 0, os.SEEK_SET)
            return received(file)
        finally:
            os.close(file)
    return pass_on


def test_read_only_mappings(through):
    """A read-only mapping stays one."""
    came = through(MappingProxyType({'a': MappingProxyType({'b': 1})}))
    assert came == {'a': {'b': 1}}
    assert isinstance(came, MappingProxyType)
    assert isinstance(came['a'], MappingProxyType)


def test_the_end_of_a_pipe():
    """A pipe without a writer is readable, and what comes is nothing; a half message is, too."""
    for begun in (b'', b'\x07\0\0', b'\x07\0\0\0\0\0\0\0half'):
        outgoing, incoming = os.pipe()
        assert not readable(outgoing)
        os.write(incoming, begun)
        os.close(incoming)
        assert readable(outgoing)
        assert received(outgoing) is None
        os.close(outgoing)


@pytest.mark.parametrize('robot', ['sunday', 'bot', 'ROBOT', 'leg', 'ur5', 'magician', 'elfin'])
def test_a_job_for_any_robot(through, robot):
    """Robot, settings, scene and request of a job arrive as they were."""
    settings = load_robot_settings(robot)
    model = KinematicModel(load_robot_model(settings))
    scene = PlanningScene(model)
    link = next(name for name, item in model.robot.links.items() if item.collisions)
    corners = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]])
    wedge = Mesh(corners, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))
    scene.apply_object(CollisionObjectUpdate(
        'wedge', 0, scene.model_frame, pose=pose_matrix((2.0, 0.0, 0.0)), meshes=(wedge,)))
    scene.apply_attached(AttachedObjectUpdate(link, CollisionObjectUpdate(
        'load', 0, link, pose=pose_matrix((0.0, 0.0, 0.1)), primitives=(Box((0.1,) * 3),))))
    group = next(iter(model.robot.semantic.groups))
    request = MotionPlanRequest(group, (Constraints((JointConstraint('any', 0.5),)),))
    planning = settings_from_config(
        settings.planning_parameters, settings.ompl, settings.kinematics)
    came = through(Job(7, model.robot, planning, scene.content, request))
    assert (came.number, came.request, came.settings) == (7, request, planning)
    assert came.robot.active_joints == model.robot.active_joints
    assert came.robot.semantic == model.robot.semantic
    other = PlanningScene(KinematicModel(came.robot)).holding(came.content)
    assert set(other.objects) == {'wedge'}
    assert set(other.attached) == {'load'}
    assert np.array_equal(other.q, scene.q)
    assert other.acm.names == scene.acm.names
