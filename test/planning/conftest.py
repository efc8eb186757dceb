# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Small arms made of boxes, and what is needed to plan for them."""

import itertools
import logging
import math
from pathlib import Path
import sys

import numpy as np
import pytest

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Box
from armsim_ros.model.robot_model import (
    Joint,
    JointLimits,
    JointType,
    Link,
    LinkGeometry,
    PlanningGroup,
    RobotModel,
    SemanticModel,
)
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.planner import MotionPlanner
from armsim_ros.planning.scene import PlanningScene
from armsim_ros.planning.scene_update import CollisionObjectUpdate

sys.path.insert(0, str(Path(__file__).parent))
from six_axis_requests import WALL

X, Y, Z = np.eye(3)


def pytest_addoption(parser):
    """Add what makes random tests longer."""
    parser.addoption('--clutter', type=int, default=None, help='random problems for each robot')


class Recorder(logging.Handler):
    """Keeps what was logged."""

    def __init__(self):
        super().__init__()
        self.lines = []

    def emit(self, record):
        self.lines.append(f'{record.levelname} {record.getMessage()}')

    def text(self):
        return '\n'.join(self.lines)


@pytest.fixture
def log():
    """Return a logger whose lines can be read as ``log.recorder.text()``."""
    logger = logging.Logger('planning test')
    logger.recorder = Recorder()
    logger.addHandler(logger.recorder)
    return logger


def serial_arm(name, rows, *, joint_type=JointType.REVOLUTE, limits=None, boxes=None):
    """
    Return an arm whose joints follow one another, with a tool frame at its end.

    :param rows: (xyz, rpy, axis) of each joint.
    :param boxes: (size, xyz) of the collision box of each moving link, None for none.
    """
    limits = limits or JointLimits(-2.9, 2.9, 3.0, 8.0)
    links = {'base': Link('base')}
    joints = {}
    parent = 'base'
    for number, (xyz, rpy, axis) in enumerate(rows, 1):
        child = f'segment{number}'
        box = boxes[number - 1] if boxes else None
        shapes = () if box is None else (LinkGeometry(Box(box[0]), pose_matrix(box[1])),)
        links[child] = Link(child, collisions=shapes)
        joints[f'axis{number}'] = Joint(
            f'axis{number}', joint_type, parent, child, pose_matrix(xyz, rpy), axis, limits)
        parent = child
    links['tool'] = Link('tool')
    joints['mount'] = Joint(
        'mount', JointType.FIXED, parent, 'tool', pose_matrix((0.0, 0.0, 0.1)), Z)
    active = tuple(f'axis{number}' for number in range(1, len(rows) + 1))
    group = PlanningGroup(
        'arm', tuple(joints), active, tuple(links)[1:], ('base', 'tool'), ('tool',))
    neighbours = {
        tuple(sorted(pair)): 'Adjacent' for pair in itertools.pairwise(links)
    }
    return RobotModel(name, links, joints, 'base',
                      SemanticModel(name, {'arm': group}, {}, disabled_collisions=neighbours))


def planar_arm(**options):
    """Return three joints in the x-y plane, links of 0.4, 0.3, 0.2 m."""
    lengths = (0.4, 0.3, 0.2)
    rows = [((before, 0.0, 0.0), (0.0, 0.0, 0.0), Z) for before in (0.0, *lengths[:-1])]
    boxes = [((length - 0.08, 0.04, 0.04), (length / 2, 0.0, 0.0)) for length in lengths]
    return serial_arm('planar', rows, boxes=boxes, **options)


def six_axis_arm(**options):
    """Return a six-axis arm with shoulder, elbow and a wrist, reach about 0.9 m."""
    rows = [
        ((0.0, 0.0, 0.1), (0.0, 0.0, 0.0), Z),
        ((0.0, 0.0, 0.15), (0.0, 0.0, 0.0), Y),
        ((0.0, 0.0, 0.35), (0.0, 0.0, 0.0), Y),
        ((0.0, 0.0, 0.15), (0.0, 0.0, 0.0), Z),
        ((0.0, 0.0, 0.15), (0.0, 0.0, 0.0), Y),
        ((0.0, 0.0, 0.08), (0.0, 0.0, 0.0), Z),
    ]
    boxes = [
        ((0.1, 0.1, 0.1), (0.0, 0.0, 0.05)),
        ((0.07, 0.07, 0.27), (0.0, 0.0, 0.175)),
        ((0.06, 0.06, 0.1), (0.0, 0.0, 0.08)),
        ((0.05, 0.05, 0.09), (0.0, 0.0, 0.075)),
        ((0.05, 0.05, 0.05), (0.0, 0.0, 0.03)),
        ((0.04, 0.04, 0.04), (0.0, 0.0, 0.04)),
    ]
    return serial_arm('six', rows, boxes=boxes, **options)


@pytest.fixture(scope='session')
def planar():
    """Return the kinematics of the planar arm."""
    return KinematicModel(planar_arm())


@pytest.fixture(scope='session')
def six():
    """Return the kinematics of the six-axis arm."""
    return KinematicModel(six_axis_arm())


@pytest.fixture
def planar_scene(planar):
    """Return an empty scene with the planar arm."""
    return PlanningScene(planar)


@pytest.fixture
def six_scene(six):
    """Return an empty scene with the six-axis arm."""
    return PlanningScene(six)


@pytest.fixture
def plan_for(log):
    """Return a planner for a scene, logging into ``log``."""
    def make(scene, settings=None):
        return MotionPlanner(scene, settings=settings, log=log)
    return make


@pytest.fixture
def add_box():
    """Put a box into a scene."""
    def add(scene, name, size, xyz, rpy=(0.0, 0.0, 0.0)):
        scene.apply_object(CollisionObjectUpdate(
            name, 0, scene.model_frame, pose=pose_matrix(xyz, rpy), primitives=(Box(size),)))
    return add


@pytest.fixture
def wall(six_scene, add_box):
    """Return a scene in which a wall stands between LEFT and RIGHT."""
    add_box(six_scene, 'wall', *WALL)
    return six_scene


@pytest.fixture
def clock():
    """Return a clock that the code under test moves by asking: 0.1 ms a call."""
    ticks = itertools.count()
    return lambda: next(ticks) * 1e-4


@pytest.fixture(scope='session')
def turning():
    """Return a planar arm whose joints turn without end."""
    endless = JointLimits(-math.inf, math.inf, 3.0, 8.0)
    return planar_arm(joint_type=JointType.CONTINUOUS, limits=endless)
