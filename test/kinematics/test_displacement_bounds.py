# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of the bounds of how far links move."""

import numpy as np
import pinocchio as pin
import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.kinematics.displacement_bounds import DisplacementBounds, JointFrames
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import corner_points
from armsim_ros.model.loading import load_robot_model

LOAD = np.array([[0.05, 0.0, 0.3], [0.0, -0.1, 0.2]])


@pytest.fixture(params=['panda', 'magician', 'bot'])
def kinematics(request):
    """Return robots with joints that turn, slide and follow others."""
    return KinematicModel(load_robot_model(load_robot_settings(request.param)))


@pytest.fixture
def states(kinematics):
    """Return random states (k, n)."""
    low, high = np.maximum(kinematics.lower, -np.pi), np.minimum(kinematics.upper, np.pi)
    return np.random.default_rng(1).uniform(low, high, (40, kinematics.n))


def placed(kinematics, q):
    """Return the poses (joints, 4, 4) of all joints by Pinocchio."""
    data = kinematics.model.createData()
    pin.forwardKinematics(kinematics.model, data, q)
    return np.array([each.homogeneous for each in data.oMi])


def points_of(kinematics):
    """Return the number of a joint -> points (k, 3) of what it carries, a load on the last."""
    points = {kinematics.model.njoints - 1: [LOAD]}
    for name, link in kinematics.robot.links.items():
        joint, offset = kinematics.link_joint(name)
        for item in link.collisions:
            points.setdefault(joint, []).append(corner_points(item.geometry, offset @ item.origin))
    return {joint: np.vstack(parts) for joint, parts in points.items()}


def test_frames_of_many_states_are_those_of_each(kinematics, states):
    """The frames of joints are where Pinocchio puts them."""
    rotations, origins = JointFrames(kinematics).poses(states)
    for k, q in enumerate(states):
        poses = placed(kinematics, q)
        assert rotations[k] == pytest.approx(poses[:, :3, :3], abs=1e-12)
        assert origins[k] == pytest.approx(poses[:, :3, 3], abs=1e-12)


def test_no_link_moves_farther_against_another_than_bounded(kinematics, states):
    """Within reach of a state, what a joint carries moves no farther as another joint sees it."""
    rng = np.random.default_rng(2)
    bounds = DisplacementBounds(kinematics, {kinematics.model.njoints - 1: LOAD})
    reach = rng.uniform(0.0, 0.2, states.shape)
    weights = bounds.weights_near(bounds.frames(states), reach)
    near, anywhere = bounds.relative_displacement(reach, weights), (
        bounds.relative_displacement(reach))
    assert np.all(near <= anywhere + 1e-12)
    assert near.sum() < anywhere.sum()
    points = points_of(kinematics)
    for k, q in enumerate(states):
        before = placed(kinematics, q)
        after = placed(kinematics, q + rng.choice([-1.0, 1.0], len(q)) * reach[k])
        for other in range(len(before)):
            was, now = (np.linalg.inv(poses[other]) @ poses for poses in (before, after))
            for joint, carried in points.items():
                ways = [carried @ poses[joint][:3, :3].T + poses[joint][:3, 3]
                        for poses in (was, now)]
                farthest = np.linalg.norm(ways[1] - ways[0], axis=1).max()
                # What the other joint carries turns with it: its own motion is bounded, too.
                if other == 0 or other in _above(kinematics, joint):
                    assert farthest <= near[k, joint, other] + 1e-9


def _above(kinematics, joint):
    """Return the numbers of a joint and of those that move it."""
    found = []
    while joint:
        found.append(joint)
        joint = kinematics.model.parents[joint]
    return found
