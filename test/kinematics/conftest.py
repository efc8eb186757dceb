# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Serial arms by their joint tables, for the tests of kinematics."""

import math

import numpy as np
import pytest

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.robot_model import Joint, JointLimits, JointType, Link, Mimic, RobotModel
from armsim_ros.model.semantic_model import PlanningGroup, SemanticModel
from armsim_ros.model.transforms import pose_matrix

X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
HALF = math.pi / 2

#: xyz [m], rpy [rad], axis, lower and upper [rad] of each joint in turn.
SUNDAY = [
    ((-0.0041595, -0.12, 1.158051), (0, 0, -1.5708), Z, -2.79, 2.79),
    ((0, 0.054512, 0.049518), (-0.0041482, 0, 0), (0, -0.99999, -0.0041482), -1.54, 1.54),
    ((0, -0.0008547, 0.20604), (-3.1374, 0, 0), Y, -2.79, 2.79),
    ((0, -0.02136, -0.17442), (0, 0, 0), (0, -1, 0), -2.79, 2.79),
    ((0, -0.03573, -0.044358), (0, 0, 0), (0, 0, -1), -2.79, 2.79),
    ((0, -0.099358, -0.03573), (-1.5708, 0, -1.5708), X, -2.79, 2.79),
]
UR5 = [
    ((0, 0, 0.08916), (0, 0, 0), Z, -2 * math.pi, 2 * math.pi),
    ((0, 0.13585, 0), (0, HALF, 0), Y, -2 * math.pi, 2 * math.pi),
    ((0, -0.1197, 0.425), (0, 0, 0), Y, -math.pi, math.pi),
    ((0, 0, 0.39225), (0, HALF, 0), Y, -2 * math.pi, 2 * math.pi),
    ((0, 0.093, 0), (0, 0, 0), Z, -2 * math.pi, 2 * math.pi),
    ((0, 0, 0.09465), (0, 0, 0), Y, -2 * math.pi, 2 * math.pi),
]
PANDA = [
    ((0, 0, 0.333), (0, 0, 0), Z, -2.8973, 2.8973),
    ((0, 0, 0), (-HALF, 0, 0), Z, -1.7628, 1.7628),
    ((0, -0.316, 0), (HALF, 0, 0), Z, -2.8973, 2.8973),
    ((0.0825, 0, 0), (HALF, 0, 0), Z, -3.0718, -0.0698),
    ((-0.0825, 0.384, 0), (-HALF, 0, 0), Z, -2.8973, 2.8973),
    ((0, 0, 0), (HALF, 0, 0), Z, -0.0175, 3.7525),
    ((0.088, 0, 0), (HALF, 0, 0), Z, -2.8973, 2.8973),
]


def joint(name, kind, parent, child, origin, axis=X, limits=None, mimic=None):
    """Return a joint; the axis need not have length 1."""
    unit = np.array(axis, dtype=float) / np.linalg.norm(axis)
    return Joint(name, kind, parent, child, origin, unit, limits or JointLimits(), mimic)


def robot(name, joints, groups, root='base'):
    """Return a robot with the given joints and groups (name -> names of active joints)."""
    links = {root: Link(root), **{item.child: Link(item.child) for item in joints}}
    by_name = {item.name: item for item in joints}
    semantic = SemanticModel(
        name,
        {
            group: PlanningGroup(
                group, tuple(active), tuple(active), tuple(by_name[n].child for n in active)
            )
            for group, active in groups.items()
        },
    )
    return RobotModel(name, links, by_name, root, semantic)


def serial(name, rows, kind=JointType.REVOLUTE):
    """Return an arm with links base, link_1 ..., and ``tool`` fixed to the last."""
    joints, parent = [], 'base'
    for number, (xyz, rpy, axis, lower, upper) in enumerate(rows, 1):
        limits = JointLimits(lower, upper, 3.14)
        child = f'link_{number}'
        origin = pose_matrix(xyz, rpy)
        joints.append(joint(f'joint_{number}', kind, parent, child, origin, axis, limits))
        parent = child
    tool = pose_matrix((0.03, 0.02, 0.1), (0.1, 0.2, 0.3))
    joints.append(joint('tool_joint', JointType.FIXED, parent, 'tool', tool))
    return robot(name, joints, {'arm': [item.name for item in joints if item.active]})


@pytest.fixture(scope='session')
def sunday():
    """Return the six-joint arm of the default robot, base at the origin of its world."""
    return KinematicModel(serial('sunday', SUNDAY))


@pytest.fixture(scope='session')
def ur5():
    """Return a six-joint arm whose joints turn twice."""
    return KinematicModel(serial('ur5', UR5))


@pytest.fixture(scope='session')
def panda():
    """Return an arm with seven joints."""
    return KinematicModel(serial('panda', PANDA))


@pytest.fixture(scope='session')
def continuous():
    """Return an arm whose six joints turn without end."""
    rows = [(xyz, rpy, axis, -math.inf, math.inf) for xyz, rpy, axis, _, _ in UR5]
    return KinematicModel(serial('endless', rows, JointType.CONTINUOUS))


@pytest.fixture(scope='session')
def parallelogram():
    """Return a four-joint arm whose mimic joint keeps the tool level, as palletizers have."""
    limits = JointLimits(-1.4, 1.4, 1.0)
    joints = [
        joint('turn', JointType.REVOLUTE, 'base', 'column', pose_matrix((0, 0, 0.1)), Z,
              JointLimits(-2.2, 2.2, 1.0)),
        joint('lift', JointType.REVOLUTE, 'column', 'upper', pose_matrix(), Y, limits),
        joint('bend', JointType.REVOLUTE, 'upper', 'fore', pose_matrix((0, 0, 0.2)), Y, limits),
        joint('level_1', JointType.REVOLUTE, 'fore', 'wrist', pose_matrix((0.2, 0, 0)), Y,
              JointLimits(-3, 3, 1.0), Mimic('lift', -1.0, 0.0)),
        joint('level_2', JointType.REVOLUTE, 'wrist', 'plate', pose_matrix(), Y,
              JointLimits(-3, 3, 1.0), Mimic('bend', -1.0, 0.1)),
    ]
    return KinematicModel(robot('magician', joints, {'arm': ['turn', 'lift', 'bend']}))


@pytest.fixture(scope='session')
def two_arms():
    """Return two planar arms on one lift, with a group of both."""
    joints = [
        joint('lift', JointType.PRISMATIC, 'base', 'lift_link', pose_matrix(), Z,
              JointLimits(0.1, 0.5, 0.2)),
    ]
    arms = {'left': [], 'right': []}
    for side, y in (('left', 0.2), ('right', -0.2)):
        parent, origin = 'lift_link', pose_matrix((0, y, 0))
        for number in range(1, 4):
            name = f'{side}_{number}'
            joints.append(joint(name, JointType.REVOLUTE, parent, f'{name}_link', origin, Z,
                                JointLimits(-2.5, 2.5, 1.0)))
            arms[side].append(name)
            parent, origin = f'{name}_link', pose_matrix((0.25, 0, 0))
        tip = joint(f'{side}_tip', JointType.FIXED, parent, f'{side}_hand', origin)
        joints.append(tip)
    groups = {**arms, 'both': ['lift', *arms['left'], *arms['right']]}
    return KinematicModel(robot('torso', joints, groups))
