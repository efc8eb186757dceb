# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where the joints of a robot are in many states at once, which Pinocchio computes one by one."""

from __future__ import annotations

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.robot_model import Joint, JointType


class JointFrames:
    """
    The frames of all joints, 0 for the model frame.

    :param kinematics: the robot.
    """

    def __init__(self, kinematics: KinematicModel) -> None:
        model = kinematics.model
        self._parents = [int(parent) for parent in model.parents]
        joints = [kinematics.robot.joints[name] for name in kinematics.names]
        #: (n, 3) unit vectors in the joints' frames.
        self.axes: Matrix = np.array([unit_axis(joint) for joint in joints]).reshape(-1, 3)
        #: (n,) which joints slide.
        self.slides = np.array([joint.type is JointType.PRISMATIC for joint in joints], bool)
        placements = [model.jointPlacements[joint] for joint in range(1, len(self._parents))]
        at_zero = np.array([each.rotation for each in placements]).reshape(-1, 3, 3)
        cross = np.cross(np.eye(3), self.axes[:, None])
        # Rodrigues' formula: the first, the second by the sine, the third by 1 - the cosine.
        self._terms = at_zero, at_zero @ cross, at_zero @ cross @ cross
        self._offsets = np.array([each.translation for each in placements]).reshape(-1, 3)
        self._slopes = np.einsum('nab,nb->na', at_zero, self.axes)

    def poses(self, states: Matrix) -> tuple[Matrix, Matrix]:
        """
        Return rotations (k, joints, 3, 3) and origins (k, joints, 3) [m] in the model frame.

        :param states: (k, n) [rad or m].
        """
        turned = np.where(self.slides, 0.0, states)[..., None, None]
        first, second, third = self._terms
        steps = first + np.sin(turned) * second + (1.0 - np.cos(turned)) * third
        offsets = self._offsets + np.where(self.slides, states, 0.0)[..., None] * self._slopes
        count = len(self._parents)
        rotations = np.empty((len(states), count, 3, 3))
        origins = np.zeros((len(states), count, 3))
        rotations[:, 0] = np.eye(3)
        for joint in range(1, count):
            parent = self._parents[joint]
            np.matmul(rotations[:, parent], steps[:, joint - 1], out=rotations[:, joint])
            way = rotations[:, parent] @ offsets[:, joint - 1, :, None]
            np.add(origins[:, parent], way[..., 0], out=origins[:, joint])
        return rotations, origins


def unit_axis(joint: Joint) -> Vector:
    """Return the axis (3,) of a joint in its own frame."""
    axis = np.asarray(joint.axis, dtype=np.float64)
    unit: Vector = axis / np.linalg.norm(axis)
    return unit
