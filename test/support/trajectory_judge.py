# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A judge of trajectories that shares no code with what makes them."""

import itertools

import coal
import numpy as np

from armsim_ros.model.robot_model import JointType
from armsim_ros.model.transforms import matrix_from_axis_angle


def poses(robot, positions):
    """Return the pose of every link, from the joints' definitions alone."""
    found = {robot.root_link: np.eye(4)}
    for name, joint in robot.joints.items():
        motion = np.eye(4)
        if joint.type in (JointType.REVOLUTE, JointType.CONTINUOUS):
            motion[:3, :3] = matrix_from_axis_angle(joint.axis, positions[name])
        elif joint.type is JointType.PRISMATIC:
            motion[:3, 3] = joint.axis * positions[name]
        found[joint.child] = found[joint.parent] @ joint.origin @ motion
    return found


def penetration(robot, positions, boxes):
    """Return how deep [m] the robot's boxes are in each other or in boxes of the world."""
    at = poses(robot, positions)
    solids = [
        (name, shape.geometry.size, at[name] @ shape.origin)
        for name, link in robot.links.items() for shape in link.collisions
    ] + [('', size, pose) for size, pose in boxes]
    deepest = 0.0
    for (one, size1, pose1), (two, size2, pose2) in itertools.combinations(solids, 2):
        if not (one or two) or tuple(sorted((one, two))) in robot.semantic.disabled_collisions:
            continue
        wanted, result = coal.DistanceRequest(), coal.DistanceResult()
        distance = coal.distance(
            coal.Box(*size1), coal.Transform3s(pose1[:3, :3], pose1[:3, 3]),
            coal.Box(*size2), coal.Transform3s(pose2[:3, :3], pose2[:3, 3]), wanted, result)
        deepest = max(deepest, -distance)
    return deepest


def between(trajectory, t):
    """Return the positions at a time as a controller interpolates: a quintic, solved here."""
    k = min(int(np.searchsorted(trajectory.times, t, side='right')), len(trajectory) - 1)
    h = trajectory.times[k] - trajectory.times[k - 1]
    x = t - trajectory.times[k - 1]
    system = np.array([
        [1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 2, 0, 0, 0],
        [h**p for p in range(6)], [p * h**(p - 1) if p else 0 for p in range(6)],
        [p * (p - 1) * h**(p - 2) if p > 1 else 0 for p in range(6)]])
    values = np.array([table[end] for end in (k - 1, k) for table in (
        trajectory.positions, trajectory.velocities, trajectory.accelerations)])
    return np.array([x**p for p in range(6)]) @ np.linalg.solve(system, values)


def judge(response, robot, boxes=(), samples=250):
    """Check a trajectory without any code that made it."""
    trajectory = response.trajectory
    times = np.linspace(0.0, trajectory.duration, samples)
    states = np.array([between(trajectory, t) for t in times])
    limits = [robot.joints[name].limits for name in trajectory.joint_names]
    for state in states:
        named = dict(zip(trajectory.joint_names, state, strict=True))
        assert penetration(robot, named, boxes) == 0.0
    assert np.all(states >= np.array([each.lower for each in limits]) - 1e-6)
    assert np.all(states <= np.array([each.upper for each in limits]) + 1e-6)
    step = times[1] - times[0]
    velocity = np.diff(states, axis=0) / step
    acceleration = np.diff(velocity, axis=0) / step
    assert np.all(np.abs(velocity).max(axis=0) <= [each.velocity * 1.01 for each in limits])
    assert np.all(
        np.abs(acceleration).max(axis=0) <= [each.acceleration * 1.02 for each in limits])
    assert np.diff(trajectory.times).max() <= 0.1
