# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A planar arm with a gripper finger, small enough to know where everything is."""

import numpy as np
import pytest

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Box, Cylinder, Mesh, Sphere
from armsim_ros.model.robot_model import (
    Joint,
    JointLimits,
    JointType,
    Link,
    LinkGeometry,
    RobotModel,
)
from armsim_ros.model.semantic_model import PlanningGroup, SemanticModel, VirtualJoint
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.scene.planning_scene import PlanningScene

Z = np.array([0.0, 0.0, 1.0])


def cube_mesh(edge):
    """Return a cube as twelve triangles."""
    half = edge / 2
    vertices = np.array([[x, y, z] for x in (-half, half) for y in (-half, half)
                         for z in (-half, half)])
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])
    return Mesh(vertices, triangles)


def planar_robot(disabled=(), upper_shape=None, **semantic):
    """Return base - shoulder - elbow - finger in the plane, links of 0.4, 0.4 and 0.1 m."""
    limits = JointLimits(-3.1, 3.1, 1.0)
    rod = upper_shape or Box((0.3, 0.05, 0.05))
    along = pose_matrix((0.2, 0, 0))
    links = {
        'base': Link('base', collisions=(LinkGeometry(Cylinder(0.045, 0.1), np.eye(4)),)),
        'upper': Link('upper', collisions=(LinkGeometry(rod, along),)),
        'fore': Link('fore', collisions=(LinkGeometry(Box((0.3, 0.05, 0.05)), along),)),
        'tool': Link('tool'),
        'finger': Link(
            'finger', collisions=(LinkGeometry(Sphere(0.03), pose_matrix((0.05, 0, 0))),)
        ),
    }
    joints = [
        Joint('shoulder', JointType.REVOLUTE, 'base', 'upper', np.eye(4), Z, limits),
        Joint('elbow', JointType.REVOLUTE, 'upper', 'fore', pose_matrix((0.4, 0, 0)), Z, limits),
        Joint('tool_joint', JointType.FIXED, 'fore', 'tool', pose_matrix((0.4, 0, 0)), Z),
        Joint('grip', JointType.REVOLUTE, 'tool', 'finger', np.eye(4), Z, limits),
    ]
    groups = {
        'arm': PlanningGroup(
            'arm', ('shoulder', 'elbow'), ('shoulder', 'elbow'), ('upper', 'fore'),
            ('base', 'fore'), ('fore',),
        ),
        'hand': PlanningGroup('hand', ('grip',), ('grip',), ('finger',)),
    }
    model = SemanticModel(
        'planar',
        groups,
        disabled_collisions={tuple(sorted(pair)): 'Adjacent' for pair in disabled},
        virtual_joint=VirtualJoint('fixed_base', 'fixed', 'world', 'base'),
        **semantic,
    )
    return RobotModel('planar', links, {item.name: item for item in joints}, 'base', model)


ADJACENT = (('base', 'upper'), ('upper', 'fore'), ('fore', 'finger'))


@pytest.fixture(scope='session')
def kinematics():
    """Return the planar arm with its neighbours exempt."""
    return KinematicModel(planar_robot(ADJACENT))


@pytest.fixture
def scene(kinematics):
    """Return an empty scene."""
    return PlanningScene(kinematics)


@pytest.fixture(scope='session')
def make_robot():
    """Return the function that makes variants of the robot."""
    return planar_robot


@pytest.fixture(scope='session')
def make_mesh():
    """Return the function that makes a cube of triangles."""
    return cube_mesh


@pytest.fixture(scope='session')
def mesh_kinematics(make_robot, make_mesh):
    """Return the planar arm with a mesh for its upper link."""
    from armsim_ros.model.geometry import Mesh as MeshShape

    cube = make_mesh(0.1)
    bar = MeshShape(cube.vertices * np.array([3.0, 0.5, 0.5]), cube.triangles)
    pairs = (('base', 'upper'), ('upper', 'fore'), ('fore', 'finger'))
    return KinematicModel(make_robot(pairs, upper_shape=bar))
