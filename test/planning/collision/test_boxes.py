# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of the boxes that show which pairs of shapes may be near."""

import coal
import numpy as np
import pinocchio as pin
import pytest

from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.collision.broad_phase import BroadPhase

SHAPES, STATES = 6, 20


def broad_phase(shapes):
    """Return a broad phase of (joint, pose, shape) on an arm of two joints, and its frames."""
    model = pin.Model()
    first = model.addJoint(0, pin.JointModelRX(), pin.SE3.Identity(), 'first')
    model.addJoint(first, pin.JointModelRZ(), pin.SE3(np.eye(3), np.array([0.0, 0.3, 0.0])), 'two')
    count = len(shapes)
    for _, _, shape in shapes:
        shape.computeLocalAABB()
    pairs = np.triu(np.ones((count, count), dtype=bool), 1)
    made = BroadPhase(model, shapes, pairs, np.zeros((count, count)))
    made.activate(pairs)
    return model, made


def frames(model, states):
    """Return rotations (k, joints, 3, 3) and origins (k, joints, 3) of the joints."""
    data = model.createData()
    poses = []
    for q in states:
        pin.forwardKinematics(model, data, q)
        poses.append([pose.homogeneous for pose in data.oMi])
    poses = np.array(poses)
    return poses[..., :3, :3], poses[..., :3, 3]


@pytest.mark.parametrize('seed', range(10))
def test_no_near_pair_is_left_out(seed):
    """Every pair that is as near as its margin is among those that boxes leave."""
    rng = np.random.default_rng(seed)
    shapes = [
        (number % 3, pose_matrix(rng.uniform(-0.4, 0.4, 3), rng.uniform(-3.0, 3.0, 3)),
         coal.Cylinder(0.03, 0.5) if number % 2 else coal.Box(*rng.uniform(0.02, 0.5, 3)))
        for number in range(SHAPES)]
    model, made = broad_phase(shapes)
    states = rng.uniform(-3.0, 3.0, (STATES, 2))
    rotations, origins = frames(model, states)
    first, second = made.pairs
    margins = rng.uniform(0.0, 0.2, (STATES, len(first)))
    near = made.boxes_near(rotations, origins, margins)
    left_out = 0
    for k in range(STATES):
        placed = []
        for joint, pose, shape in shapes:
            there = pin.SE3(rotations[k, joint], origins[k, joint]) * pin.SE3(pose)
            placed.append((shape, coal.Transform3s(there.rotation, there.translation)))
        for pair, (a, b) in enumerate(zip(first, second, strict=True)):
            if shapes[a][0] == shapes[b][0]:
                continue
            distance = coal.distance(
                *placed[a], *placed[b], coal.DistanceRequest(), coal.DistanceResult())
            assert near[k, pair] or distance > margins[k, pair]
            left_out += not near[k, pair]
    assert left_out > 10


def test_slanted_boxes_are_apart_along_their_own_axes():
    """Two long boxes side by side are told apart where boxes along the world's axes overlap."""
    slanted = pose_matrix((0.0, 0.0, 0.0), (0.0, 0.0, 0.7))
    beside = slanted @ pose_matrix((0.0, 0.1, 0.0), (0.0, 0.0, 0.0))
    bar = coal.Box(1.0, 0.02, 0.02)
    model, made = broad_phase([(0, slanted, bar), (1, beside, coal.Box(1.0, 0.02, 0.02))])
    rotations, origins = frames(model, np.zeros((1, 2)))
    assert not made.boxes_near(rotations, origins, np.full((1, 1), 0.079)).any()
    assert made.boxes_near(rotations, origins, np.full((1, 1), 0.081)).all()
