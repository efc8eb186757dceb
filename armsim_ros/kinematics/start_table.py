# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Sampled configurations with their poses: good starts for inverse kinematics."""

from __future__ import annotations

import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.transforms import inverse_pose


class StartTable:
    """
    Configurations of a group, sampled once, and where they put a set of links.

    Poses are kept relative to the link that carries the group's first joint, so that joints
    outside the group may be anywhere. Two poses count as near when positions, measured in
    the spread of all samples, and orientations, measured as the chord between rotation
    matrices, are near.

    :param kinematics: the robot.
    :param group: planning group whose variables are sampled.
    :param links: links whose poses are kept.
    :param size: number of samples.
    """

    def __init__(
        self, kinematics: KinematicModel, group: str, links: tuple[str, ...], size: int
    ) -> None:
        self._kinematics = kinematics
        self._links = links
        self._base = base_link(kinematics, group)
        indices = kinematics.group_indices(group)
        self.low, self.high = sampling_range(kinematics.lower[indices], kinematics.upper[indices])
        rng = np.random.default_rng(0)
        self.samples: Matrix = rng.uniform(self.low, self.high, (size, len(indices)))
        self._poses: Matrix = np.empty((size, len(links), 4, 4))
        q = kinematics.default()
        for row, values in enumerate(self.samples):
            self._poses[row] = self._relative(kinematics.insert(q, group, values))
        spread = self._poses[:, :, :3, 3].std(axis=0).max(initial=0.0)
        self._length = max(float(spread), 1e-3)

    def _relative(self, q: Vector) -> Matrix:
        base, *poses = self._kinematics.link_poses(q, (self._base, *self._links))
        relative: Matrix = inverse_pose(base) @ np.array(poses)
        return relative

    def best_first(
        self, targets: Matrix, q: Vector, count: int, *, position_only: bool = False
    ) -> Matrix:
        """
        Return the samples (count, m) whose poses are nearest to the targets.

        :param targets: (links, 4, 4) wanted poses in the model frame.
        :param q: (n,) state of the joints outside the group.
        :param position_only: leave orientations out.
        """
        base = self._kinematics.link_pose(q, self._base)
        wanted = inverse_pose(base) @ targets
        difference = self._poses - wanted
        cost = (difference[:, :, :3, 3] ** 2).sum(axis=(1, 2)) / self._length**2
        if not position_only:
            # |R1 - R2|^2 = 8 sin^2(angle / 2) in the Frobenius norm.
            cost += (difference[:, :, :3, :3] ** 2).sum(axis=(1, 2, 3)) / 2.0
        if count >= len(cost):
            order = np.argsort(cost, kind='stable')
        else:
            order = np.argpartition(cost, count)[:count]
            order = order[np.argsort(cost[order], kind='stable')]
        best: Matrix = self.samples[order]
        return best


def base_link(kinematics: KinematicModel, group: str) -> str:
    """Return the link that carries the first of a group's active joints."""
    robot = kinematics.robot
    active = robot.semantic.groups[group].active_joints
    return robot.joints[active[0]].parent if active else robot.root_link


def sampling_range(lower: Vector, upper: Vector) -> tuple[Vector, Vector]:
    """
    Return finite bounds to sample between; where a turn or more is free, a turn about 0.

    :param lower: (m,) [rad or m], may be infinite.
    :param upper: (m,) [rad or m], may be infinite.
    """
    low, high = lower.copy(), upper.copy()
    wide = upper - lower >= 2.0 * math.pi
    with_zero = wide & (lower <= -math.pi) & (upper >= math.pi)
    low[with_zero], high[with_zero] = -math.pi, math.pi
    for bound, other, sign in ((low, high, -1.0), (high, low, 1.0)):
        endless = ~np.isfinite(bound)
        bound[endless] = other[endless] + sign * 2.0 * math.pi
    return low, high
