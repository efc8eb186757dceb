# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Small arms made of boxes, and what is needed to plan for them."""

import itertools
import logging

import pytest
from six_axis_requests import WALL
from small_arms import planar_arm, six_axis_arm, turning_arm, two_six_axis_arms

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.constraints import ConstraintSet
from armsim_ros.planning.planner import MotionPlanner
from armsim_ros.planning.request import Constraints
from armsim_ros.planning.scene.objects import CollisionObject, ObjectShape
from armsim_ros.planning.scene.planning_scene import PlanningScene


def pytest_addoption(parser):
    """Add what makes random tests longer."""
    parser.addoption('--clutter', type=int, default=None, help='random problems for each robot')
    parser.addoption('--placements', type=int, default=None,
                     help='placements of two shapes that are checked for contact')
    parser.addoption('--states', type=int, default=None,
                     help='random states that are checked for collisions')
    parser.addoption('--placement-seed', type=int, default=None, help='first of their seeds')


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


@pytest.fixture(scope='session')
def planar():
    """Return the kinematics of the planar arm."""
    return KinematicModel(planar_arm())


@pytest.fixture(scope='session')
def six():
    """Return the kinematics of the six-axis arm."""
    return KinematicModel(six_axis_arm())


@pytest.fixture(scope='session')
def pair():
    """Return the kinematics of two six-axis arms with a group of both."""
    return KinematicModel(two_six_axis_arms())


@pytest.fixture
def pair_scene(pair):
    """Return an empty scene with both arms bent, away from singularities."""
    scene = PlanningScene(pair)
    scene.set_positions({
        f'{side}_axis{k}': value for side in ('left', 'right')
        for k, value in enumerate((0.3, 0.7, 1.2, 0.2, 0.9, 0.1), 1)})
    return scene


@pytest.fixture
def planar_scene(planar):
    """Return an empty scene with the planar arm."""
    return PlanningScene(planar)


@pytest.fixture
def constraint_set(planar_scene, log):
    """Return a function that prepares constraints for the planar arm."""
    def build(*, joints=(), positions=(), orientations=(), visibilities=()):
        return ConstraintSet(
            Constraints(joints, positions, orientations, visibilities), planar_scene, log)
    return build


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
        scene.apply_object(CollisionObject(
            name, 0, scene.model_frame, pose=pose_matrix(xyz, rpy),
            shapes=(ObjectShape(Box(size)),)))
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
    return turning_arm()
