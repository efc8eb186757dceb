# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Ways through the joint space on which path constraints are kept."""

import math

import numpy as np
import pytest

from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.collision.state_validity import StateValidity
from armsim_ros.planning.request import OrientationConstraint
from armsim_ros.planning.search.joint_space import ConstrainedSpace, PROJECTION_STEP


def test_the_way_to_a_forbidden_target_ends_beside_it(planar, planar_scene, constraint_set):
    """Each step comes nearer to the target; where none does, the way ends."""
    level = OrientationConstraint('tool', (0.0, 0.0, 0.0, 1.0), (4.0, 4.0, 0.2), 'base')
    polls = iter(range(500))
    validity = StateValidity(
        CollisionChecker(planar_scene), planar, 'arm', planar_scene.q,
        constraint_set(orientations=(level,)), poll=lambda: next(polls))
    start, target = np.zeros(3), np.array([1.2, 0.0, 0.0])
    space = ConstrainedSpace(validity, start, 0.05, exact=True)
    way = space.steer(start, target, 1.2, math.inf)
    # The sum of the three joints is the tool's angle.
    assert way[-1] == pytest.approx(target - 1.0 / 3.0, abs=2.0 * PROJECTION_STEP)
    assert np.all(np.diff(np.linalg.norm(way - target, axis=1)) < 0.0)
    assert space.join(start, target) is None


def test_two_states_are_joined_by_states_that_keep_the_constraints(
        planar, planar_scene, constraint_set):
    """They are close together, and neither of the two is among them."""
    level = OrientationConstraint('tool', (0.0, 0.0, 0.0, 1.0), (4.0, 4.0, 0.01), 'base')
    validity = StateValidity(
        CollisionChecker(planar_scene), planar, 'arm', planar_scene.q,
        constraint_set(orientations=(level,)))
    start, target = np.zeros(3), np.array([0.4, -0.2, -0.2])
    between = ConstrainedSpace(validity, start, 0.05, exact=True).join(start, target)
    way = np.vstack((start, between, target))
    assert len(between) > 1
    steps = np.linalg.norm(np.diff(way, axis=0), axis=1)
    assert 0.0 < steps.min() <= steps.max() < 1.1 * PROJECTION_STEP
    assert np.abs(way.sum(axis=1)).max() < 0.011
