# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Trajectories of planar and floating joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.model.robot_model import JointType, RobotModel
from armsim_ros.trajectory import JointTrajectory

#: Type of a joint -> its variables, in the order of a state.
VARIABLES = {
    JointType.PLANAR.value: ('x', 'y', 'theta'),
    JointType.FLOATING.value: (
        'trans_x', 'trans_y', 'trans_z', 'rot_x', 'rot_y', 'rot_z', 'rot_w'),
}


@dataclass(frozen=True, slots=True, eq=False)
class MultiDofTrajectory:
    """
    k waypoints of n joints that have several degrees of freedom each.

    :param joint_names: (n,).
    :param times: (k,) from the trajectory's start [s].
    :param transforms: (k, n, 7) position [m] and quaternion xyzw of each joint.
    :param velocities: (k, n, 6) linear [m/s] and angular [rad/s], None where not all are given.
    :param stamp_ns: [ns] when the trajectory starts; 0 is "as soon as it arrives".
    """

    joint_names: tuple[str, ...]
    times: Vector
    transforms: Matrix
    velocities: Matrix | None = None
    stamp_ns: int = 0

    def __len__(self) -> int:
        """Return the number of waypoints."""
        return len(self.times)

    @property
    def duration(self) -> float:
        """Time of the last waypoint [s], 0 for a trajectory without any."""
        return float(self.times[-1]) if len(self) else 0.0

    def of_joints(self, joint_names: Sequence[str], velocity: float = 1.0) -> MultiDofTrajectory:
        """Return the part of some of its joints, velocities multiplied by a factor."""
        columns = [self.joint_names.index(name) for name in joint_names]
        return replace(
            self, joint_names=tuple(joint_names), transforms=self.transforms[:, columns],
            velocities=None if self.velocities is None
            else self.velocities[:, columns] * velocity)


def multi_dof_joints(robot: RobotModel) -> dict[str, tuple[str, ...]]:
    """Return planar and floating joint -> names of its variables, the virtual joint among them."""
    virtual = robot.semantic.virtual_joint
    types = {name: joint.type.value for name, joint in robot.joints.items()}
    if virtual is not None:
        types[virtual.name] = virtual.type
    return {
        name: tuple(f'{name}/{variable}' for variable in VARIABLES[kind])
        for name, kind in types.items() if kind in VARIABLES
    }


def as_joint_trajectory(
    trajectory: JointTrajectory, multi_dof: MultiDofTrajectory, robot: RobotModel
) -> JointTrajectory:
    """
    Return a trajectory of joints and of the variables of multi-DOF joints; it starts at once.

    :param trajectory: of the same number of points, or without any.
    :raises PlanningError: CONTROL_FAILED where the two do not fit, or a joint is not known.
    """
    known = multi_dof_joints(robot)
    unknown = [name for name in multi_dof.joint_names if name not in known]
    if unknown or len(trajectory) not in (0, len(multi_dof)):
        raise PlanningError(
            MoveItErrorCode.CONTROL_FAILED,
            f'the multi-DOF trajectory cannot be executed: it has {len(multi_dof)} points beside '
            f'{len(trajectory)} of the joints, and the joints '
            f'{", ".join(multi_dof.joint_names) or "none"}; multi-DOF joints of the robot: '
            f'{", ".join(known) or "none"}', 'trajectory execution')
    names = list(trajectory.joint_names) if len(trajectory) else []
    blocks = [trajectory.positions] if names else []
    for column, name in enumerate(multi_dof.joint_names):
        names += known[name]
        blocks.append(_variables(multi_dof.transforms[:, column], len(known[name])))
    return JointTrajectory(tuple(names), multi_dof.times, np.concatenate(blocks, axis=1))


def _variables(poses: Matrix, count: int) -> Matrix:
    """Return the variables (k, count) of a joint at poses (k, 7)."""
    if count == len(VARIABLES[JointType.FLOATING.value]):
        return poses
    x, y, z, w = poses[:, 3:].T
    theta = [math.atan2(2 * (d * c + a * b), 1 - 2 * (b * b + c * c))
             for a, b, c, d in zip(x, y, z, w, strict=True)]
    planar: Matrix = np.column_stack([poses[:, 0], poses[:, 1], theta])
    return planar
