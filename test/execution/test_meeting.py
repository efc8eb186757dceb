# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Two motions of two arms that may meet."""

import numpy as np
import pytest

from armsim_ros.execution.rules import meeting
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.trajectory import JointTrajectory


@pytest.fixture(scope='module')
def cell():
    """Return two arms beside each other."""
    return load_cell('two_bots')


@pytest.fixture(scope='module')
def model(cell):
    """Return their kinematics."""
    return KinematicModel(cell.model)


def motion(model, robot, *ways):
    """Return a motion of one robot through joint positions."""
    names = tuple(name for name in model.names if name in robot.model.active_joints)
    return JointTrajectory(names, np.arange(float(len(ways))), np.array(ways))


def test_arms_that_stay_apart(cell, model):
    """Small motions about the start do not meet."""
    checker = CollisionChecker(PlanningScene(model))
    q = model.default()
    motions = []
    for robot in cell.robots:
        start = np.array([q[model.index(name)] for name in model.names
                          if name in robot.model.active_joints])
        motions.append(motion(model, robot, start, start + 0.05))
    assert meeting(checker, q, *motions) is None


def test_arms_that_meet_are_found(cell, model):
    """Of random motions some meet; the contact is one of a link of each, and it is real."""
    checker = CollisionChecker(PlanningScene(model))
    q, random = model.default(), np.random.default_rng(4)
    found = None
    for _ in range(200):
        motions = [
            motion(model, robot, *random.uniform(-2.0, 2.0, (2, len(robot.model.active_joints))))
            for robot in cell.robots
        ]
        found = meeting(checker, q, *motions)
        if found is not None:
            break
    assert found is not None
    prefixes = {found.body1.partition('_')[0], found.body2.partition('_')[0]}
    assert len(prefixes) == 2
