# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The kinematic tree: its order, which links are adjacent, and where every link is."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.model.robot_model import Joint, JointType, RobotModel
from armsim_ros.model.transforms import matrix_from_axis_angle, pose_from_parts


def tree_order(root_link: str, joints: Mapping[str, Joint]) -> tuple[list[str], list[str]]:
    """
    Return links and joints depth first from the root.

    Joints below a link follow each other in the order of their names, as in MoveIt, whose
    joint order is that of a map.
    """
    below: dict[str, list[str]] = {}
    for name in sorted(joints):
        below.setdefault(joints[name].parent, []).append(name)
    links, order = [root_link], []
    seen = {root_link}
    pending = list(reversed(below.get(root_link, [])))
    while pending:
        name = pending.pop()
        child = joints[name].child
        if child in seen:
            continue
        seen.add(child)
        order.append(name)
        links.append(child)
        pending.extend(reversed(below.get(child, [])))
    return links, order


def joint_pose(joint: Joint, position: float) -> Matrix:
    """
    Return the pose (4, 4) of a joint's child link in its parent link.

    :param position: [rad or m]; has no effect on a fixed, floating or planar joint.
    """
    if joint.type in (JointType.REVOLUTE, JointType.CONTINUOUS):
        turn: Matrix = np.eye(4)
        turn[:3, :3] = matrix_from_axis_angle(joint.axis, position)
        return joint.origin @ turn
    if joint.type is JointType.PRISMATIC:
        return joint.origin @ pose_from_parts(joint.axis * position, np.eye(3))
    return joint.origin


def link_poses(robot: RobotModel, positions: Mapping[str, float]) -> dict[str, Matrix]:
    """
    Return the pose (4, 4) of every link in the root link's frame, in tree order.

    :param positions: joint -> [rad or m]; the others are at their default, mimic joints follow.
    """
    full = robot.complete(dict(positions))
    poses: dict[str, Matrix] = {robot.root_link: np.eye(4)}
    for name, joint in robot.joints.items():
        poses[joint.child] = poses[joint.parent] @ joint_pose(joint, full.get(name, 0.0))
    return poses


def standing_links(robot: RobotModel) -> tuple[str, ...]:
    """Return the links that no joint moves."""
    standing = [robot.root_link]
    for joint in robot.joints.values():
        if joint.type is JointType.FIXED and joint.parent in standing:
            standing.append(joint.child)
    return tuple(standing)


def adjacent_pairs(robot: RobotModel) -> list[tuple[str, str]]:
    """
    Return pairs of links with geometry that need no check for collisions, in tree order.

    These are links that a joint of any type connects, directly or by way of links without
    geometry (compute_default_collisions.cpp: computeConnectionGraph), and links that never move
    relative to each other.
    """
    solid = [name for name, link in robot.links.items() if link.collisions]
    # Links without geometry that are connected are one node of the graph.
    empty: dict[str, str] = {}
    bodies = {robot.root_link: robot.root_link}
    for name in robot.links:
        joint = robot.joints.get(robot.parent_joint.get(name, ''))
        if joint is not None:
            fixed = joint.type is JointType.FIXED
            bodies[name] = bodies[joint.parent] if fixed else name
        if not robot.links[name].collisions:
            empty[name] = name if joint is None else empty.get(joint.parent, name)
    neighbours: dict[str, set[str]] = {name: set() for name in (*solid, *empty.values())}
    for joint in robot.joints.values():
        ends = [empty.get(name, name) for name in (joint.parent, joint.child)]
        neighbours[ends[0]].add(ends[1])
        neighbours[ends[1]].add(ends[0])
    reached = {name: neighbours[name].union(
        *(neighbours[node] for node in neighbours[name] if node not in solid)) for name in solid}
    return [
        (min(a, b), max(a, b))
        for i, a in enumerate(solid)
        for b in solid[i + 1:]
        if b in reached[a] or bodies[a] == bodies[b]]
