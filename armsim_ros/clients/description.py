# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A robot from its published descriptions: URDF, SRDF, no files of ours."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
import math

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.model.description.srdf import parse_srdf
from armsim_ros.model.description.urdf import parse_urdf
from armsim_ros.model.description.urdf_elements import Scale
from armsim_ros.model.geometry import Mesh
from armsim_ros.model.robot_model import Joint, JointType, RobotModel
from armsim_ros.model.semantic_model import PlanningGroup, SemanticModel
from armsim_ros.model.transforms import matrix_from_quat_xyzw
from armsim_ros.model.tree import joint_pose


def describe(urdf: str, srdf: str = '') -> RobotModel:
    """
    Return the robot of two texts; meshes keep their address and scale, nothing is read.

    The scale of a mesh is in its ``vertices``, (1, 3).

    :raises ModelError: a text is wrong.
    """
    def place(uri: str, scale: Scale) -> Mesh:
        return Mesh(np.array([scale]), np.zeros((0, 3), np.int64), uri)

    content = parse_urdf(urdf, '/robot_description', read_mesh=place, read_visual_mesh=place)
    semantic = SemanticModel()
    if srdf:
        semantic = parse_srdf(
            srdf, '/robot_description_semantic', robot_name=content.name,
            root_link=content.root_link, links=content.links, joints=content.joints,
        ).semantic
    return RobotModel(content.name, content.links, content.joints, content.root_link, semantic,
                      urdf=urdf, srdf=srdf)


def with_limits(robot: RobotModel, overrides: Mapping[str, Mapping[str, float]]) -> RobotModel:
    """
    Return the robot with limits that a planner uses in place of the URDF's.

    :param overrides: joint -> 'velocity' or 'acceleration' -> [rad/s or rad/s^2].
    """
    joints = {
        name: replace(joint, limits=replace(joint.limits, **overrides[name]))
        if name in overrides else joint
        for name, joint in robot.joints.items()}
    return replace(robot, joints=joints)


def link_pose(robot: RobotModel, link: str, positions: Mapping[str, float]) -> Matrix:
    """
    Return the pose of a link in the root link, (4, 4).

    :param positions: every movable joint's [rad or m]; those that are not given are at 0.
    """
    pose = np.eye(4)
    while link != robot.root_link:
        joint = robot.joints[robot.parent_joint[link]]
        pose = joint_pose(joint, positions.get(joint.name, 0.0)) @ pose
        link = joint.parent
    return pose


def tip_of(group: PlanningGroup) -> str:
    """Return the link that is dragged and led along lines; '' where the group has no end."""
    if group.chain is not None:
        return group.chain[1]
    return group.tips[0] if len(group.tips) == 1 else ''


def bounds(joint: Joint) -> tuple[float, float]:
    """Return the positions that a joint may be set to; a turn each way where it has no limits."""
    lower, upper = joint.limits.lower, joint.limits.upper
    return (lower if math.isfinite(lower) else -math.pi,
            upper if math.isfinite(upper) else math.pi)


def moved_links(robot: RobotModel, group: str) -> frozenset[str]:
    """Return the links that a group's joints move."""
    moving = set(robot.group(group).active_joints)
    found: set[str] = set()
    for link in robot.links:  # parents first
        joint = robot.joints[robot.parent_joint[link]] if link in robot.parent_joint else None
        if joint is not None and (joint.name in moving or joint.parent in found):
            found.add(link)
    return frozenset(found)


def position_of(joint: Joint, xyz: Matrix, xyzw: Matrix) -> float:
    """Return the position of a joint [rad or m] whose child has a pose in its parent."""
    offset = np.asarray(xyz) - joint.origin[:3, 3]
    if joint.type is JointType.PRISMATIC:
        return float((joint.origin[:3, :3] @ joint.axis) @ offset)
    turn = joint.origin[:3, :3].T @ matrix_from_quat_xyzw(xyzw)
    across = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    return float(np.arctan2(0.5 * joint.axis @ across, 0.5 * (np.trace(turn) - 1.0)))
