# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Bounds of the driven joints as arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.model.robot_model import Joint, JointType, RobotModel
from armsim_ros.sim.physics.robot_spec import bound_or_infinite

#: A servo follows references this much faster than the joint's rated velocity, so that a
#: trajectory at the limit does not fall behind where its splines swing over it.
VELOCITY_HEADROOM = 1.1


@dataclass(frozen=True, slots=True, eq=False)
class DrivenLimits:
    """
    Bounds of all joints with a motor; infinite where there is none.

    :param lower: (n,) [rad or m].
    :param upper: (n,) [rad or m].
    :param velocity: (n,) [rad/s or m/s], with the headroom.
    :param effort: (n,) [N*m or N].
    """

    lower: Vector
    upper: Vector
    velocity: Vector
    effort: Vector

    @classmethod
    def of(cls, model: RobotModel) -> DrivenLimits:
        """Return the limits of a robot's active joints, in their order."""
        joints = [model.joints[name] for name in model.active_joints]
        endless = [joint.type is JointType.CONTINUOUS for joint in joints]
        lower = np.array([joint.limits.lower for joint in joints], dtype=np.float64)
        upper = np.array([joint.limits.upper for joint in joints], dtype=np.float64)
        lower[endless], upper[endless] = -np.inf, np.inf
        velocity = [bound_or_infinite(joint.limits.velocity) for joint in joints]
        effort = [bound_or_infinite(joint.limits.effort) for joint in joints]
        return cls(lower, upper, VELOCITY_HEADROOM * np.array(velocity), np.array(effort))

    def bounded(self, start: Vector, requested: Matrix, longest: Vector, weights: Vector
                ) -> Matrix:
        """
        Return a reference to the requested positions, as far as the limits allow.

        :param start: (n,) where it is now [rad or m].
        :param requested: (k, n) positions after each step.
        :param longest: (n,) ways in a step [rad or m].
        :param weights: (n,) 1 by ``longest``.
        :returns: (k + 1, n), the start first.
        """
        references = np.empty((len(requested) + 1, requested.shape[1]))
        references[0] = start
        np.maximum(requested, self.lower, out=references[1:])
        np.minimum(references[1:], self.upper, out=references[1:])
        shares = (references[1:] - references[:-1]) * weights
        # Where the squares of all shares do not add up to one, none is above it.
        if float(np.vdot(shares, shares)) < 1.0 or not (np.abs(shares) > 1.0).any():
            return references
        for i in range(1, len(references)):
            way = references[i] - references[i - 1]
            if (np.abs(way * weights) > 1.0).any():
                references[i] = references[i - 1] + np.clip(way, -longest, longest)
        return references


def fingers_driven(model: RobotModel) -> Vector:
    """
    Return for how many fingers each active joint has force (n,), in their order; 1 for most.

    Sliding joints that mimic a sliding joint are fingers of a gripper. Each presses with the
    requested effort, as if it had its own drive; a common motor would share it.
    """
    counts = dict.fromkeys(model.active_joints, 1.0)
    for joint in model.joints.values():
        leader, multiplier, _ = model.driver_of(joint.name)
        if leader is not joint and _slides(joint) and _slides(leader) and leader.name in counts:
            counts[leader.name] += abs(multiplier)
    return np.array(list(counts.values()))


def _slides(joint: Joint) -> bool:
    return joint.type is JointType.PRISMATIC
