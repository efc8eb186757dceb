# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Small arms made of boxes."""

from dataclasses import replace
import itertools
import math

import numpy as np

from armsim_ros.model.geometry import Box
from armsim_ros.model.robot_model import (
    Joint,
    JointLimits,
    JointType,
    Link,
    LinkGeometry,
    RobotModel,
)
from armsim_ros.model.semantic_model import PlanningGroup, SemanticModel
from armsim_ros.model.transforms import pose_matrix

_, Y, Z = np.eye(3)


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


def two_six_axis_arms():
    """Return two six-axis arms 1 m apart, with the groups left, right and both."""
    links, joints, groups = {'world': Link('world')}, {}, {}
    for side, y in (('left', 0.5), ('right', -0.5)):
        arm = six_axis_arm()
        links.update({f'{side}_{name}': replace(link, name=f'{side}_{name}')
                      for name, link in arm.links.items()})
        foot = Joint(f'{side}_foot', JointType.FIXED, 'world', f'{side}_base',
                     pose_matrix((0.0, y, 0.0)), Z)
        for each in (foot, *(replace(
                joint, name=f'{side}_{name}', parent=f'{side}_{joint.parent}',
                child=f'{side}_{joint.child}') for name, joint in arm.joints.items())):
            joints[each.name] = each
        groups[side] = PlanningGroup(
            side, *(tuple(f'{side}_{name}' for name in names) for names in (
                arm.joints, arm.active_joints, tuple(arm.links)[1:])),
            (f'{side}_base', f'{side}_tool'), (f'{side}_tool',))
    left, right = groups['left'], groups['right']
    groups['both'] = PlanningGroup(
        'both', left.joints + right.joints, left.active_joints + right.active_joints,
        left.links + right.links, None, left.tips + right.tips, ('left', 'right'))
    neighbours = {tuple(sorted((joint.parent, joint.child))): 'Adjacent'
                  for joint in joints.values()}
    return RobotModel('pair', links, joints, 'world',
                      SemanticModel('pair', groups, {}, disabled_collisions=neighbours))


def turning_arm():
    """Return a planar arm whose joints turn without end."""
    endless = JointLimits(-math.inf, math.inf, 3.0, 8.0)
    return planar_arm(joint_type=JointType.CONTINUOUS, limits=endless)
