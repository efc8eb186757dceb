# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Bounds of the driven joints as arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsim_ros.model.robot_model import JointType, RobotModel
from armsim_ros.sim.robot_spec import bound_or_infinite

Vector = NDArray[np.float64]

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
