# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Pinocchio's model of a robot: a joint per movable joint, a frame per link."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pinocchio as pin

from armsim_ros.arrays import Matrix
from armsim_ros.model.robot_model import Joint, JointType, RobotModel


class KinematicTree:
    """
    The joints and links of a robot in Pinocchio's numbers.

    Joints are numbered from 1 in the order of ``RobotModel.movable_joints``; 0 is the model
    frame. Every joint has a variable, continuous joints too.

    :param robot: the robot.
    """

    def __init__(self, robot: RobotModel) -> None:
        self.model: Any = pin.Model()
        #: Link -> (number of the joint that carries it, its pose (4, 4) on that joint).
        self.places: dict[str, tuple[int, Matrix]] = {}
        #: Link -> number of its frame.
        self.frames: dict[str, int] = {}
        self._place(robot.root_link, 0, np.eye(4))
        for joint in robot.joints.values():
            carrier, offset = self.places[joint.parent]
            pose = offset @ joint.origin
            if joint.movable:
                added = self.model.addJoint(
                    carrier, _joint_model(joint), pin.SE3(pose), joint.name
                )
                self._place(joint.child, added, np.eye(4))
            else:
                self._place(joint.child, carrier, pose)

    def _place(self, link: str, carrier: int, offset: Matrix) -> None:
        self.places[link] = (carrier, offset)
        self.frames[link] = self.model.addFrame(
            pin.Frame(f'link {link}', carrier, pin.SE3(offset), pin.FrameType.BODY)
        )


def mimic_rules(robot: RobotModel) -> tuple[tuple[int, int, float, float], ...]:
    """Return (index, master's index, multiplier, offset), masters that mimic resolved."""
    indices = {name: index for index, name in enumerate(robot.movable_joints)}
    rules = []
    for name in robot.movable_joints:
        multiplier, offset = 1.0, 0.0
        joint = robot.joints[name]
        while joint.mimic is not None:
            offset += multiplier * joint.mimic.offset
            multiplier *= joint.mimic.multiplier
            joint = robot.joints[joint.mimic.joint]
        if joint.name != name:
            rules.append((indices[name], indices[joint.name], multiplier, offset))
    return tuple(rules)


def position_bounds(joint: Joint) -> tuple[float, float]:
    """Return lower and upper bound [rad or m]; a continuous joint has none."""
    if joint.type is JointType.CONTINUOUS:
        return -math.inf, math.inf
    return joint.limits.lower, joint.limits.upper


def _joint_model(joint: Joint) -> Any:
    axis = np.asarray(joint.axis, dtype=np.float64)
    x, y, z = axis / np.linalg.norm(axis)
    if joint.type is JointType.PRISMATIC:
        return pin.JointModelPrismaticUnaligned(x, y, z)
    return pin.JointModelRevoluteUnaligned(x, y, z)
