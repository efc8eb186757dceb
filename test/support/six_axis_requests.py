# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Requests for the six-axis arm, as clients send them."""



from armsim_ros.model.geometry import Sphere
from armsim_ros.model.transforms import pose_matrix, quat_xyzw_from_matrix
from armsim_ros.planning.request import (
    Constraints,
    JointConstraint,
    MotionPlanRequest,
    OrientationConstraint,
    PositionConstraint,
    Region,
)
from armsim_ros.planning.scene.update import StartState

SIX = tuple(f'axis{k}' for k in range(1, 7))
LEFT = (-0.9, 1.2, 0.3, 0.0, 0.5, 0.0)
RIGHT = (0.9, 1.2, 0.3, 0.0, 0.5, 0.0)
WALL = ((0.05, 0.6, 0.9), (0.4, 0.0, 0.45))
"""Size and place [m] of a wall between LEFT and RIGHT."""


def joint_goal(values, names=SIX, tolerance=1e-4):
    """Return a goal for all joints, as clients send it."""
    return Constraints(tuple(
        JointConstraint(name, value, tolerance, tolerance)
        for name, value in zip(names, values, strict=True)))


def pose_goal(pose, link='tool', position=1e-4, angle=1e-3):
    """Return a goal for a link's pose in the base frame, as clients send it."""
    region = Region(Sphere(position), pose_matrix(pose[:3, 3]))
    return Constraints(
        position_constraints=(PositionConstraint(link, (region,), 'base'),),
        orientation_constraints=(OrientationConstraint(
            link, tuple(quat_xyzw_from_matrix(pose)), (angle,) * 3, 'base', 1),))


def request(goal, start=LEFT, **options):
    """Return a repeatable request for the six-axis arm."""
    options.setdefault('seed', 1)
    goals = goal if isinstance(goal, tuple) else (goal,)
    return MotionPlanRequest('arm', goals, StartState(SIX[:len(start)], tuple(start)), **options)
